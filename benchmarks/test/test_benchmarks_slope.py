"""The slope part: its manoeuvres, how it counts, and the shipped processors on a few seeds."""

from argparse import Namespace
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from benchmarks.protocol import CORNER, DT
from benchmarks.slope import part as slope_part
from benchmarks.slope.detection import (
    Detection,
    Run,
    Settings,
    below_the_peak,
    detect,
    shipped_settings,
    through_the_peak,
)
from benchmarks.slope.part import disagreement, row
from corner_sim.sensors import CHAPTER_NOISE, NO_NOISE
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface


@pytest.fixture(scope="module")
def settings() -> Settings:
    return shipped_settings(imu=True)


@pytest.mark.parametrize("name", TABLE_8_1)
def test_manoeuvre_passes_the_peak_to_twice_its_slip_and_returns(name: str) -> None:
    run = through_the_peak(name)
    up, down = run.crossings()
    assert 0.4 < up < down < run.time[-1]
    assert 2.0 * run.lambda_max < run.slip.max() < 3.0 * run.lambda_max
    assert np.interp(up, run.time, run.slip) == pytest.approx(run.lambda_max, abs=1e-9)
    assert run.slip[-1] < run.lambda_max


@pytest.mark.parametrize("name", TABLE_8_1)
def test_false_alarm_run_stays_below_the_peak(name: str) -> None:
    run = below_the_peak(name, 0.92, 1.5)
    assert run.slip.max() < run.lambda_max
    assert run.torque.max() == pytest.approx(0.92 * float(CORNER.peak_torque(surface(name))))
    assert np.isnan(run.crossings()).all()


def test_rates_of_the_truth_are_the_derivatives_of_its_signals() -> None:
    run = through_the_peak("dry")
    before = slice(90, 125)
    rate = np.gradient(run.slip, DT)
    np.testing.assert_allclose(run.slip_rate[before], rate[before], atol=0.02)
    acceleration = np.gradient(run.wheel_speed, DT)
    np.testing.assert_allclose(run.wheel_acceleration[before], acceleration[before], atol=0.5)


def test_interval_of_disagreement_is_where_eta_lies_between_zero_and_the_friction_in_use() -> None:
    for name in TABLE_8_1:
        run = through_the_peak(name)
        mu = burckhardt.friction(run.theta, run.slip)
        within = (run.eta > 0.0) & (run.eta < (1.0 - run.slip) * mu) & (run.torque > 0.0)
        assert sum(disagreement(run)) == pytest.approx(DT * float(within.sum()))


@pytest.mark.parametrize("name", TABLE_8_1)
@pytest.mark.parametrize("method", ["slip", "no_slip"])
def test_noise_free_sign_flips_within_the_documented_delay_and_one_sample(
    name: str, method: str, settings: Settings
) -> None:
    run = through_the_peak(name)
    up, down = run.crossings()
    found = detect(run, settings.exact(), NO_NOISE, 0)[method]
    assert found.delay == pytest.approx(DT)
    assert 0.0 <= found.lost - up <= found.delay + DT
    assert 0.0 <= found.regained - down <= found.delay + DT


@pytest.mark.parametrize("name", ["dry", "cobblestone"])
def test_shipped_processors_find_the_peak_in_noise_and_stay_silent_below_it(name: str, settings: Settings) -> None:
    run, level = through_the_peak(name), below_the_peak(name, 0.92, 0.5)
    up, down = run.crossings()
    for seed in (1, 2):
        for found in detect(run, settings, CHAPTER_NOISE, seed).values():
            assert 0.0 <= found.lost - up < 0.2
            assert found.slip == pytest.approx(run.lambda_max, rel=0.25)
            assert found.regained > down
        assert all(np.isnan(found.lost) for found in detect(level, settings, CHAPTER_NOISE, seed).values())


def counted(run: Run, delays: list[float]) -> dict[str, float]:
    up, down = run.crossings()
    found = [Detection(up + delay, run.lambda_max, down + 0.01, np.zeros(1), 0.0675) for delay in delays]
    return row("dry", "slip", run, found, 0.25)


def test_missed_and_early_detections_count_as_infinitely_late() -> None:
    run = through_the_peak("dry")
    some = counted(run, [0.01, 0.02, 0.03, nan, -0.01])
    assert some["delay_median_ms"] == pytest.approx(30.0)
    assert some["missed_percent"] == pytest.approx(20.0)
    assert some["early_percent"] == pytest.approx(20.0)
    assert some["false_alarm_percent"] == pytest.approx(25.0)
    assert some["slip_error_percent"] == pytest.approx(0.0)
    assert counted(run, [0.01, nan, nan])["delay_median_ms"] == inf


def test_slip_of_early_detections_does_not_enter_the_mean() -> None:
    run = through_the_peak("dry")
    up, down = run.crossings()
    good = Detection(up + 0.01, run.lambda_max, down, np.zeros(1), 0.0)
    bad = replace(good, lost=up - 0.1, slip=0.0)
    assert row("dry", "slip", run, [good, bad], 0.0)["slip_mean"] == pytest.approx(run.lambda_max)


def test_part_gives_a_flat_row_for_each_surface_and_method(monkeypatch: pytest.MonkeyPatch) -> None:
    surfaces = ("wet", "snow")
    monkeypatch.setattr(slope_part, "TABLE_8_1", surfaces)
    rows = slope_part.run(Namespace(seeds=1, no_imu=True))
    assert [(r["surface"], r["method"]) for r in rows] == [(s, m) for s in surfaces for m in ("slip", "no_slip")]
    assert all(isinstance(value, int | float | str) for r in rows for value in r.values())


def test_part_judges_cars_with_load_transfer_where_there_is_an_accelerometer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slope_part, "TABLE_8_1", ())
    rows = slope_part.run(Namespace(seeds=1, no_imu=False))
    assert {r["surface"] for r in rows} == {"high_grip_stop", "low_grip_stop", "dry"}
    assert all("value" in r for r in rows)
