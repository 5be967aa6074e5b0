"""Confidence of a sign: parameter errors, cycles within the window, remembered slips."""

from math import inf, nan

import numpy as np
import pytest

from friction_slope.crossing import MEMORY, NEARER, ToldSlips
from friction_slope.detector import LOCKED_TYRE_SLIP, DetectorParameters, SlopeDetector
from friction_slope.estimate import Method, SlopeEstimate, SlopeSample
from friction_slope.indicator import Doubt, doubt_of
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

STEP = 5_000_000
CORNER = load_vehicle("chapter_corner").corner("front_left")
KNOWN = Doubt()
SHORT = DetectorParameters(window=10, rate_window=10, load_transfer=False)


def drive(doubt: Doubt | None, slips: np.ndarray, h: np.ndarray, torque_rate: float = 0.0) -> list[SlopeEstimate]:
    """Feed a detector with slips, and a wheel whose speed and torque make H what it shall be; at 25 m/s."""
    detector = SlopeDetector(CORNER, Method.SLIP, SHORT, doubt=doubt)
    rates = np.gradient(slips, 0.005)
    acceleration = np.cumsum(h - torque_rate / CORNER.inertia) * 0.005 - 50.0
    speed = 80.0 + np.cumsum(acceleration) * 0.005
    return [
        detector.update(
            SlopeSample((k + 1) * STEP, speed[k], 400.0 + torque_rate * 0.005 * k, slips[k], rates[k], 25.0)
        )
        for k in range(len(slips))
    ]


RISING = 0.02 + 0.0015 * np.arange(60)
RUNNING_AWAY = np.minimum(0.004 * 1.25 ** np.arange(60), 0.7)


def test_rise_of_h_that_gain_and_inertia_may_have_made_is_no_sure_sign() -> None:
    h = np.full(30, 300.0)
    sure, unsure, settled = (
        drive(doubt, RISING[:30], h, torque_rate=rate)[-1]
        for doubt, rate in ((KNOWN, 3000.0), (Doubt(share=0.05), 3000.0), (Doubt(share=0.05), 500.0))
    )
    assert [each.sign for each in (sure, unsure, settled)] == [1, 1, 1]
    assert [each.reason for each in (sure, unsure, settled)] == [Reason.OK, Reason.NOT_LASTING, Reason.OK]


def test_sign_of_a_window_whose_older_half_is_beyond_the_peak_is_not_valid() -> None:
    """A return through the peak: beyond it H is positive as slip falls, below it negative and larger."""
    slips = np.concatenate([np.full(30, 0.3), 0.3 - 0.01 * np.arange(20)])
    h = np.concatenate([np.zeros(30), np.full(8, 500.0), np.full(12, -3000.0)])
    found = drive(KNOWN, slips, h)
    told = [k for k in range(50) if found[k].sign > 0]
    assert told
    assert found[told[0]].reason is Reason.NOT_LASTING
    half = SHORT.window // 2
    assert all(not k - SHORT.window + half < 38 for k in told if found[k].reason is Reason.OK)


def test_slip_that_has_come_much_nearer_to_the_peak_takes_the_validity() -> None:
    h = np.full(60, 300.0)
    assert drive(KNOWN, RISING, h)[30].reason is Reason.OK
    run_away = drive(KNOWN, RUNNING_AWAY, h)[20]
    assert (run_away.sign, run_away.reason) == (1, Reason.NOT_LASTING)


def test_vote_is_not_asked_for_certainty() -> None:
    h = np.full(60, 300.0)
    assert drive(None, RUNNING_AWAY, h)[20].reason is Reason.OK


def test_locked_wheel_is_valid_once_its_tyre_must_have_followed() -> None:
    detector = SlopeDetector(CORNER, Method.SLIP, SHORT, relaxation_length=0.3, doubt=KNOWN)
    built_up, found = 0.05, []
    for k in range(60):
        slip = 0.05 if k < 30 else 0.9
        built_up += (slip - built_up) * (1.0 - np.exp(-5.0 * 0.005 / 0.3)) if k else 0.0
        speed = 5.0 * (1.0 - slip) / CORNER.radius
        if k == 30:  # the brake alone cannot stop it within a sample
            speed = 0.5 * (speed + 5.0 * 0.95 / CORNER.radius)
        found.append((detector.update(SlopeSample((k + 1) * STEP, speed, 3000.0, slip, 0.0, 5.0)), built_up))
    locked = [(estimate, tyre) for estimate, tyre in found if estimate.indicator < -1e4]
    assert {estimate.sign for estimate, _ in locked} == {-1}
    assert {estimate.reason for estimate, _ in locked} == {Reason.OK, Reason.NOT_LASTING}
    for estimate, tyre in locked:
        assert (estimate.reason is Reason.OK) == (tyre >= LOCKED_TYRE_SLIP)


def test_doubt_adds_what_is_stated_of_gain_inertia_and_delay() -> None:
    doubt = doubt_of(load_vehicle("compact_car"), "front_left")
    assert doubt.share == pytest.approx(np.hypot(7.5e-6 / 1.3e-4, 0.1))
    assert doubt.delay == pytest.approx(0.012)
    assert doubt.of_h(1000.0, 0.0) == pytest.approx(1000.0 * doubt.share)
    assert doubt.of_h(0.0, 50_000.0) == pytest.approx(600.0)
    assert doubt_of(load_vehicle("chapter_corner"), "front_left").of_h(1e4, 1e6) == 0.0


def test_slip_below_a_stable_one_is_stable_and_above_one_beyond_the_peak_beyond() -> None:
    told = ToldSlips()
    assert not told.cover(1, 0.01, 0)
    assert not told.cover(-1, 0.9, 0)
    told.tell(1, 0.10, 0)
    told.tell(-1, 0.20, 0)
    assert told.cover(1, 0.10 * NEARER, STEP)
    assert not told.cover(1, 0.10, STEP)
    assert told.cover(-1, 0.20 / NEARER, STEP)
    assert not told.cover(-1, 0.20, STEP)
    assert not told.cover(0, 0.01, STEP)
    assert not told.cover(1, nan, STEP)
    assert not told.cover(-1, nan, STEP)


def test_what_was_told_is_forgotten_in_time_and_by_its_contradiction() -> None:
    told = ToldSlips()
    told.tell(1, 0.10, 0)
    assert told.cover(1, 0.05, MEMORY)
    assert not told.cover(1, 0.05, MEMORY + STEP)
    told.tell(1, 0.10, 0)
    told.tell(-1, 0.06, STEP)  # another road
    assert not told.cover(1, 0.05, STEP)
    told.tell(1, 0.10, 2 * STEP)
    assert not told.cover(-1, 0.5, 2 * STEP)
    told.tell(1, nan, 2 * STEP)
    assert not told.cover(1, inf, 2 * STEP)
