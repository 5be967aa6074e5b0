"""The smart tyre's limits, the chapter's sign checks (section 8.4.5) and the bounds of the fronts."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.smart_tyre import part as smart_tyre
from benchmarks.smart_tyre.part import Waveform, noise_covariance
from benchmarks.smart_tyre.runs import (
    LOW,
    NOISY,
    NOMINAL,
    PHASES,
    QUIET,
    RING,
    CalibrationRuns,
    Estimated,
    calibration_runs,
    estimate,
    means,
    passages,
    simulate,
)
from corner_sim.smart_tyre.drives import CAR, dynamic_drive
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreSignalSource
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.wheel_forces import drag, wheel_forces

Phases = Mapping[tuple[str, float], Mapping[str, tuple[float, float]]]


@pytest.fixture(scope="module")
def runs() -> CalibrationRuns:
    return calibration_runs(NOISY)


@pytest.fixture(scope="module")
def known(runs: CalibrationRuns) -> Calibration:
    return runs.calibrate()


@pytest.fixture(scope="module")
def ideal() -> Calibration:
    return calibration_runs(QUIET).calibrate()


@pytest.fixture(scope="module")
def estimates(known: Calibration) -> dict[tuple[str, float], Estimated]:
    found = {}
    for axle in ("front", "rear"):
        for pressure in (NOMINAL, LOW):
            drive = dynamic_drive(road_seed=0)
            table = ToothTable(np.asarray(known.wheels[axle].tooth_table))
            seen = passages(simulate(drive, axle, 0, NOISY, pressure), table)
            found[axle, pressure] = estimate(seen, known, drive, axle)
    return found


@pytest.fixture(scope="module")
def phases(estimates: dict[tuple[str, float], Estimated]) -> Phases:
    """Mean shift and length [deg] of each phase."""
    found = {}
    for key, e in estimates.items():
        shift, length = (means(e.time, np.degrees(values)) for values in (e.shift, e.length))
        found[key] = {phase: (shift[phase], length[phase]) for phase in PHASES}
    return found


def test_limits_are_those_of_the_projects_table() -> None:
    assert smart_tyre.LIMITS == {
        ("2.0 bar", "angle RMS (deg)"): 0.02,
        ("2.0 bar, no jitter", "crossing scatter / (noise/slope)"): 1.2,
        ("2.0 bar, no jitter", "template scatter / Cramer-Rao bound"): 1.5,
        ("2.0 bar", "Fz RMSE against reference [%]"): 3.5,
        ("2.0 bar", "Fz RMSE against truth [%]"): 2.0,
        ("2.0 bar", "Fx RMSE [%]"): 6.0,
        ("noise off", "Fz RMSE against truth [%]"): 0.5,
        ("noise off", "Fx RMSE [%]"): 2.0,
        ("1.6 bar", "Fz bias [%]"): 10.0,
        ("1.6 bar", "Fx RMSE [%]"): 8.0,
        ("1.6 bar, re-zeroed", "Fz RMSE against reference [%]"): 3.5,
        ("one tooth missing", "Fz RMSE against truth [%]"): 1.43,
        ("one tooth missing", "Fx RMSE [%]"): 5.46,
        ("ring 60-2", "Fz RMSE against truth [%]"): 1.43,
        ("ring 60-2", "Fx RMSE [%]"): 5.46,
        ("cost", "four wheels, 10 ms blocks, algorithm [% of a core]"): 5.0,
    }
    parser = argparse.ArgumentParser()
    smart_tyre.add_arguments(parser)
    assert parser.parse_args([]).seeds == 30


@pytest.mark.parametrize("pressure", [NOMINAL, LOW])
@pytest.mark.parametrize("axle", ["front", "rear"])
class TestSignsOfEveryPhase:
    def test_constant_speed_has_no_shift_and_always_the_same_length(
        self, phases: Phases, axle: str, pressure: float
    ) -> None:
        steady = [phases[axle, pressure][name] for name in ("low speed", "cruise", "low speed again")]
        # One speed map for both axles leaves each axle half the difference of their steady forces, 0.06 degrees.
        assert all(abs(shift) < 0.15 for shift, _ in steady)
        assert np.ptp([length for _, length in steady]) < 0.5
        if pressure == NOMINAL:
            assert all(length == pytest.approx(25.0, abs=0.4) for _, length in steady)

    def test_acceleration_shifts_the_driven_wheel_only(self, phases: Phases, axle: str, pressure: float) -> None:
        shift, _ = phases[axle, pressure]["acceleration"]
        if axle == "front":
            assert abs(shift) < 0.15
        else:
            assert shift > 1.0

    def test_acceleration_loads_the_rear(self, phases: Phases, axle: str, pressure: float) -> None:
        change = phases[axle, pressure]["acceleration"][1] - phases[axle, pressure]["low speed"][1]
        assert change < -1.0 if axle == "front" else change > 1.0

    def test_braking_shifts_both_wheels_back(self, phases: Phases, axle: str, pressure: float) -> None:
        assert phases[axle, pressure]["braking"][0] < -1.0

    def test_braking_loads_the_front(self, phases: Phases, axle: str, pressure: float) -> None:
        change = phases[axle, pressure]["braking"][1] - phases[axle, pressure]["low speed"][1]
        assert change > 3.0 if axle == "front" else change < -3.0


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_low_pressure_makes_the_patch_longer_and_leaves_the_shift_alike(phases: Phases, axle: str) -> None:
    for phase in PHASES:
        low, nominal = phases[axle, LOW][phase], phases[axle, NOMINAL][phase]
        assert 0.5 < low[1] - nominal[1] < 3.0
        assert low[0] == pytest.approx(nominal[0], rel=0.1, abs=0.1)


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_forces_of_a_drive_that_was_not_calibrated_with_stay_within_the_limits(
    estimates: dict[tuple[str, float], Estimated], axle: str
) -> None:
    nominal, low = estimates[axle, NOMINAL], estimates[axle, LOW]

    def rms(error: Any) -> float:
        return 100.0 * float(np.sqrt(np.mean(error**2))) / RING.static_load

    limits = smart_tyre.LIMITS
    assert rms(nominal.fz - nominal.fz_reference) < limits["2.0 bar", "Fz RMSE against reference [%]"]
    assert rms(nominal.fz - nominal.fz_true) < limits["2.0 bar", "Fz RMSE against truth [%]"]
    assert rms(nominal.fx - nominal.fx_true) < limits["2.0 bar", "Fx RMSE [%]"]
    assert abs(np.mean(low.fz - low.fz_true)) * 100.0 / RING.static_load < limits["1.6 bar", "Fz bias [%]"]
    assert rms(low.fx - low.fx_true) < limits["1.6 bar", "Fx RMSE [%]"]
    assert len(nominal.time) > 0.9 * nominal.revolutions


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_stated_deviations_cover_the_errors_even_of_fz_at_the_wrong_pressure(
    estimates: dict[tuple[str, float], Estimated], axle: str
) -> None:
    nominal, low = estimates[axle, NOMINAL], estimates[axle, LOW]
    for error, stddev in (
        (nominal.fx - nominal.fx_true, nominal.fx_stddev),
        (nominal.fz - nominal.fz_true, nominal.fz_stddev),
        (low.fz - low.fz_true, low.fz_stddev),
    ):
        assert np.mean(np.abs(error) < 1.96 * stddev) > 0.9


def test_steady_part_of_fx_is_restored_unless_switched_off(known: Calibration) -> None:
    drive = dynamic_drive(road_seed=1)
    table = ToothTable(np.asarray(known.wheels["rear"].tooth_table))
    seen = passages(simulate(drive, "rear", 1, NOISY), table)
    with_it, without = (estimate(seen, known, drive, "rear", restore=restore) for restore in (True, False))
    cruise = (with_it.time > 22.0) & (with_it.time < 41.0)
    at_zero = float(wheel_forces(CAR, 8.0, 0.0).fx_rear)
    # The zero takes off what acts at 8 m/s. The common map takes off the growth of drag, a quarter for each wheel, but
    # only half of that: coasting down the tyres feel no drag.
    hidden = at_zero + 0.5 * 0.25 * float(drag(CAR, 22.0) - drag(CAR, 8.0))
    assert np.mean((with_it.fx - without.fx)[cruise]) == pytest.approx(hidden, abs=10.0)
    errors = [abs(float(np.mean((e.fx - e.fx_true)[cruise]))) for e in (with_it, without)]
    assert errors[0] < errors[1]


def test_noise_covariance_is_that_of_the_simulated_noise() -> None:
    loud = replace(AccelerometerParameters.ideal(), texture_noise=4.0 * 9.81, electronic_noise=0.3 * 9.81)

    def signal(p: AccelerometerParameters) -> Any:
        source = TyreSignalSource(RING, p, EncoderParameters.ideal(), wheel_seed=1, noise_seed=1)
        return source.advance(np.full(100_000, 20.0 / RING.radius), 0.0, RING.static_load).radial_acceleration

    noise = (signal(loud) - signal(AccelerometerParameters.ideal()))[100:].astype(np.float64)
    seen = np.array([np.mean(noise[: len(noise) - k] * noise[k:]) for k in range(20)])
    expected = noise_covariance(loud, 20.0, 20)
    np.testing.assert_allclose(seen, expected, atol=0.03 * expected[0])


@pytest.mark.parametrize("speed", [8.0, 22.0])
def test_cramer_rao_bound_lies_below_noise_over_slope(speed: float) -> None:
    waveform = Waveform(speed)
    assert np.all(waveform.cramer_rao() < waveform.noise_over_slope())
    # Fronts alike: the patch is symmetric, the sensor's filter is not quite.
    bounds = waveform.cramer_rao()
    assert bounds[0] == pytest.approx(bounds[1], rel=0.2)


def test_rows_name_case_axle_quantity_value_limit_and_whether_it_holds(known: Calibration, ideal: Calibration) -> None:
    with Progress(disable=True) as progress:
        rows = list(smart_tyre.evaluate(range(1), known, ideal, progress))
    assert all(set(row) == {"case", "axle", "quantity", "value", "limit", "passed"} for row in rows)
    limited = {(row["case"], limit) for row in rows for limit in [row["limit"]] if limit is not None}
    assert len(limited) == len({(case, limit) for (case, _), limit in smart_tyre.LIMITS.items() if case != "cost"})
    assert all((row["passed"] is None) == (row["limit"] is None) for row in rows)
    assert {row["axle"] for row in rows} == {"front", "rear"}
    assert all(np.isfinite(row["value"]) for row in rows)
