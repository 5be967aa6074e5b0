"""A wheel whose brake opens within a slide measures the speed of the car on any grade."""

from collections.abc import Callable
from math import exp, nan, sqrt

import numpy as np
import pytest

from wheel_slip.released_wheels import ReleasedWheels
from wheel_slip.speed_filter import AccelerometerParameters, SpeedFilter
from wheel_slip.tuning import ReleasedTuning, SpeedFilterTuning
from wheel_slip.unseen_road import UnseenRoad

DT = 0.005
MS = 1_000_000
NOISE = 0.015**2
SPEED = 20.0
"""[m/s] as it is integrated."""
OPENS = 0.5
"""[s] when the brake of the second wheel opens."""
Rim = Callable[[float], float]


def held(gap: float) -> Rim:
    return lambda _time: SPEED + gap


def back(slip: float, end: float, after: float = OPENS) -> Rim:
    """A wheel with a slip that comes back to a gap of `end` [m/s] with a time constant of 15 ms."""
    return lambda t: SPEED + end - (slip * SPEED + end) * exp(-max(t - after, 0.0) / 0.015)


def told(rims: list[Rim], torques: list[Callable[[float], float]], seed: int = 1, dt: float = DT) -> list[float]:
    """What the wheels tell within a second."""
    wheels, rng = ReleasedWheels(ReleasedTuning(), len(rims)), np.random.default_rng(seed)
    found = []
    for k in range(round(1.0 / dt)):
        t = k * dt
        speeds = [rim(t) + sqrt(NOISE) * rng.normal() for rim in rims]
        gap = wheels.update(dt, [torque(t) for torque in torques], speeds, SPEED, NOISE)
        if gap is not None:
            found.append(gap)
    return found


def closed(_time: float) -> float:
    return 200.0


def opened(t: float) -> float:
    return 200.0 if t < OPENS else 3.0


@pytest.mark.parametrize("dt", [0.001, 0.005, 0.02])
@pytest.mark.parametrize("error", [-1.0, 0.0, 1.0])
def test_a_released_wheel_tells_once_by_how_much_the_speed_is_wrong(error: float, dt: float) -> None:
    found = told(
        [held(error - 1.2), back(0.06 - error / SPEED, error), held(error - 1.3)], [closed, opened, closed], 1, dt
    )
    assert found == pytest.approx([error], abs=ReleasedTuning().slip * SPEED)


def test_a_wheel_that_stays_in_its_slip_tells_nothing_though_its_pressure_reads_zero() -> None:
    assert not told([held(-1.2), held(-1.2), held(-1.3)], [closed, opened, closed])


def test_a_wheel_that_still_swings_tells_nothing() -> None:
    swings: Rim = lambda t: SPEED - (1.2 if t < OPENS else 0.3 * np.sin(60.0 * t))  # noqa: E731
    assert not told([held(-1.2), swings], [closed, opened])


def test_a_wheel_that_another_one_outruns_is_not_the_one_that_rolls() -> None:
    assert not told([held(0.0), back(0.1, -0.8)], [closed, opened])


def test_a_brake_that_was_never_closed_or_is_not_known_opens_for_nothing() -> None:
    assert not told([held(-1.2), back(0.06, 0.0)], [closed, lambda _t: 3.0])
    assert not told([held(-1.2), back(0.06, 0.0)], [closed, lambda t: 200.0 if t < OPENS else nan])


def test_reset_forgets_that_a_brake_was_closed() -> None:
    wheels = ReleasedWheels(ReleasedTuning(), 1)
    for _ in range(40):
        wheels.update(DT, [200.0], [SPEED - 1.2], SPEED, NOISE)
    wheels.reset()
    assert all(wheels.update(DT, [0.0], [SPEED], SPEED, NOISE) is None for _ in range(60))


def sliding(seconds: float, reading: float) -> SpeedFilter:
    """A filter that has integrated through a slide from 25 m/s."""
    f = SpeedFilter(AccelerometerParameters(bias_stddev=0.01), SpeedFilterTuning(gain_stddev=0.0), 0.0, 0.0, 0.0)
    f.predict(5 * MS, reading)
    f.start(25.0, 1e-4)
    for k in range(round(seconds / DT)):
        f.predict((k + 2) * 5 * MS, reading, observed=False, sliding=True)
    return f


@pytest.mark.parametrize("slope", [-0.6, 0.6])
def test_a_reference_takes_the_speed_and_the_slope_that_made_it_wrong(slope: float) -> None:
    """Uphill the accelerometer reads less deceleration than the car has."""
    f = sliding(2.0, -1.9)
    truth = f.speed - 2.0 * slope
    f.refer(truth, 0.05**2, 2.0)
    assert f.speed == pytest.approx(truth, abs=0.1)
    assert f.speed_variance < 0.06**2
    # the step may have come within the two seconds, so that it is not all of the difference
    assert 0.6 < f.offset / slope <= 1.0
    assert abs(f.offset - slope) < 2.0 * sqrt(f.offset_variance)


def test_a_reference_that_agrees_changes_little_and_makes_no_other_wheel_more_credible() -> None:
    f = sliding(2.0, -1.9)
    speed, offset, steady = f.speed, f.offset, f.steady_road_variance
    f.refer(speed + 0.05, 0.05**2, 2.0)
    assert f.offset == pytest.approx(offset, abs=0.05)
    assert f.steady_road_variance <= max(steady, 0.05**2)
    for k in range(400):
        f.predict((402 + k) * 5 * MS, -1.9, observed=False, sliding=True)
    assert f.steady_road_variance < 0.25 * f.speed_variance


@pytest.mark.parametrize("slope", [-0.6, 0.6])
def test_a_slope_that_began_on_the_way_is_covered_until_the_next_reference(slope: float) -> None:
    """It began halfway to the first reference, which takes it for half as steep."""
    f = sliding(1.0, -1.9)
    truth = f.speed
    for k in range(2, 802):
        f.predict((200 + k) * 5 * MS, -1.9, observed=False, sliding=True)
        truth += (-1.9 - slope) * DT
        if k in (201, 601):
            f.refer(truth, 0.05**2, 2.0)
        if k > 201:
            assert abs(f.speed - truth) < 1.96 * sqrt(f.speed_variance)
    assert f.offset == pytest.approx(slope, abs=0.25)


def test_no_reference_makes_the_slope_steeper_than_one_that_was_there_all_the_time() -> None:
    f = sliding(1.5, -1.9)
    f.doubt_road(1.0)
    for k in range(100):
        f.predict((302 + k) * 5 * MS, -1.9, observed=False, sliding=True)
    before, truth = f.offset, f.speed - 0.8
    f.refer(truth, 0.05**2, 2.0)
    assert 0.0 < f.offset - before <= 0.4 + 1e-9


def test_a_doubt_of_the_past_is_that_of_a_step_which_long_ago() -> None:
    road = UnseenRoad(0.0, 0.0, 5.0)
    road.doubt_past(0.36, 2.0)
    assert road.total == pytest.approx((1.44, -0.72, 0.36))


def test_what_is_left_of_the_slope_after_a_reference_is_what_the_speed_does_not_tell() -> None:
    road = UnseenRoad(0.0, 0.0, 5.0)
    road.doubt_past(0.36, 2.0)
    road.refer(1.44 + 0.01)
    assert road.total == pytest.approx((0.0, 0.0, 0.36 * 0.01 / 1.45))
