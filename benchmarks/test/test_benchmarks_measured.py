"""The whole-vehicle fit and the curve fit on measured data; skipped where the data are not beside the repository."""

import argparse
from pathlib import Path

import pytest

from benchmarks import measured
from benchmarks import measured as measured_data
from benchmarks.measured import tyre_rig_rows
from benchmarks.runner import Row
from benchmarks.slip.consistency import laps_rows
from friction_parameters.parameter import ParameterError

DATA = measured_data.data_directory()
needs_data = pytest.mark.skipif(
    not (DATA / measured_data.BMW).is_file(), reason=f"measured data are absent: {DATA} (set FRICTION_DATA)"
)


@needs_data
def test_the_bmw_stop_gives_a_peak_with_an_honest_interval() -> None:
    samples = measured.bmw_samples(measured.bmw_columns(DATA / measured_data.BMW))
    row = measured.vehicle_row("bmw", samples, measured_data.BMW_M8)
    assert row["valid"]
    assert row["lambda_max"] == pytest.approx(0.064, abs=0.002)
    assert row["mu_max"] == pytest.approx(1.17, abs=0.02)
    assert row["lambda_low"] <= 0.066 <= row["lambda_high"]
    assert row["lambda_high"] - row["lambda_low"] < 0.06


@needs_data
def test_the_speed_of_a_race_car_with_a_late_accelerometer_is_covered_with_and_without_its_speed_sensor() -> None:
    rows = laps_rows(DATA / measured_data.IAC)
    assert len(rows) == 4
    assert all(row["passed"] for row in rows)
    assert min(row["valid"] for row in rows) > 0.8


@needs_data
def test_laps_without_strong_braking_give_no_peak() -> None:
    row = measured.vehicle_row("iac", measured.iac_samples(DATA / measured_data.IAC), measured_data.INDY_AV21)
    assert row["valid_estimates"] == 0
    assert not row["valid"]


@needs_data
def test_time_shifts_of_the_bmw_stop_stay_inside_the_interval_and_give_method_car_no_peak() -> None:
    rows = measured.shifted_rows(DATA / measured_data.BMW)
    assert [row["data"] for row in rows].count("shifted") == 6
    assert [row["data"] for row in rows].count("car") == 6
    assert all(row["passed"] for row in rows)
    assert all(row["valid"] for row in rows if row["data"] == "shifted")


def test_a_shifted_peak_outside_of_its_interval_fails() -> None:
    straight = {"lambda_max": 0.064, "mu_max": 1.17}
    moved = {"lambda_max": 0.09, "lambda_low": 0.07, "lambda_high": 0.11, "mu_max": 1.17, "mu_max_stddev": 0.02}
    assert not measured.shifted_row("bmw", moved | {"valid": True}, straight)["passed"]
    assert measured.shifted_row("bmw", moved | {"valid": False}, straight)["passed"]
    assert not measured.shifted_row("bmw", moved | {"valid": True, "lambda_max": 0.065, "mu_max": 1.3}, straight)[
        "passed"
    ]


@needs_data
@pytest.mark.parametrize("front", [0.5, 0.75])
def test_method_car_takes_no_demand_for_a_pressure(front: float) -> None:
    samples = measured.bmw_car_samples(measured.bmw_columns(DATA / measured_data.BMW), front)
    row = measured.car_row("bmw", samples, measured_data.BMW_M8, counted=False)
    assert row["passed"] and "uncertain" in row["other_answers"]


@needs_data
def test_method_car_is_silent_over_laps_without_strong_braking() -> None:
    samples = measured.iac_car_samples(DATA / measured_data.IAC)
    row = measured.car_row("iac", samples, measured_data.INDY_AV21, counted=True)
    assert row["passed"] and "peak_not_passed" in row["other_answers"]


@pytest.fixture(scope="module")
def rig() -> dict[str, Row]:
    return {str(row["case"]): row for row in tyre_rig_rows(DATA / measured_data.TYRE_RIG)}


@needs_data
@pytest.mark.parametrize("load", ["0.55-0.8 kN", "1.4-1.7 kN", "2-3.2 kN"])
def test_tyre_rig_sweeps_fit_the_curve_and_their_halves_agree(rig: dict[str, Row], load: str) -> None:
    row = rig[f"{load}, 83 kPa"]
    assert row["residual_rms"] <= 0.05
    assert row["halves_overlap"]


@needs_data
def test_sweeps_that_end_before_the_peak_claim_none(rig: dict[str, Row]) -> None:
    ending_early = [row for row in rig.values() if not row["lambda_max"] < 0.155]
    assert len(ending_early) >= 3
    assert not any(row["valid"] for row in ending_early)


def test_absent_data_are_named(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=measured_data.BMW):
        measured.run(argparse.Namespace(data=tmp_path))
