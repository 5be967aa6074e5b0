"""Slope sign on cars with load transfer: the driver's stops of 8.2.3, and ordinary braking."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from benchmarks.runner import failures
from benchmarks.slope import driver_stops as stops_module
from benchmarks.slope.detection import Detection, shipped_settings
from benchmarks.slope.driver_stops import LATEST, StopTruth, driver_stops, true_stop
from benchmarks.slope.part import ordinary_braking, sensor_messages
from corner_sim.plant import SAMPLE_TIME
from friction_bags.experiments.stops import STOPS
from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY

SETTINGS = shipped_settings(imu=True)


@pytest.mark.parametrize("name", STOPS)
def test_slip_of_a_stop_is_at_lambda_max_at_its_crossings(name: str) -> None:
    truth = true_stop(name, 1.5)
    slip = np.array([sample.slip[0] for sample in truth.samples])
    assert truth.lambda_max == pytest.approx(float(burckhardt.peak(truth.samples[0].theta[0])[0]))
    assert np.interp([truth.up, truth.down], truth.time, slip) == pytest.approx([truth.lambda_max] * 2)
    inside = (truth.time > truth.up) & (truth.time < truth.down)
    assert (slip[inside] > truth.lambda_max).all()
    assert slip[truth.time <= truth.up].max() <= truth.lambda_max


def test_shipped_processors_find_the_peak_of_the_drivers_stops_and_regain_it() -> None:
    rows = driver_stops(range(2), SETTINGS)
    assert len([row for row in rows if row["passed"] is not None]) == 2 * 2 * 5
    assert failures(rows) == []


def test_as_printed_the_growing_load_hides_the_peak() -> None:
    rows = [row for row in driver_stops(range(1), SETTINGS) if "printed" in row["quantity"]]
    delays = {(row["surface"], row["method"]): row["value"] for row in rows}
    assert delays["high_grip_stop", "slip"] > 2.0 * LATEST
    assert delays["high_grip_stop", "no_slip"] > 2.0 * LATEST


def judged(truth: StopTruth, *found: Detection) -> dict[str, bool]:
    return {row["quantity"]: row["passed"] for row in stops_module._judged("stop", "slip", truth, found)}


def test_missed_late_and_early_detections_of_a_stop_do_not_pass() -> None:
    truth = true_stop("high_grip_stop", 1.5)
    good = Detection(truth.up + 0.1, 1.1 * truth.lambda_max, truth.down + 0.05, np.zeros(1), 0.0)
    assert False not in judged(truth, good, good).values()
    late = replace(good, lost=truth.up + 0.14)
    assert [name for name, passed in judged(truth, good, good, late).items() if passed is False] == ["delay, p95 [ms]"]
    early = judged(truth, good, replace(good, slip=0.8 * truth.lambda_max))
    assert [name for name, passed in early.items() if passed is False] == [
        "slip at detection over lambda_max, smallest"
    ]
    none = replace(good, lost=nan, slip=nan, regained=nan)
    missed = judged(truth, good, none, none)
    assert [passed for passed in missed.values() if passed is not None] == [False] * 5


def test_nothing_is_beyond_the_peak_in_ordinary_braking() -> None:
    rows = ordinary_braking(range(1), SETTINGS)
    assert [row["method"] for row in rows] == ["slip", "no_slip"]
    assert failures(rows) == []


def test_ordinary_braking_reaches_the_deceleration_it_is_named_by() -> None:
    held = [
        -message.linear_acceleration.x
        for k, sample in enumerate(sensor_messages(0.3, 0.1, 0))
        for topic, message in sample
        if topic == "imu/data" and 1.0 < k * SAMPLE_TIME < 1.6
    ]
    assert np.mean(held) == pytest.approx(0.3 * GRAVITY, rel=0.1)
