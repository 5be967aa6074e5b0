"""A braked wheel that stays close confirms the speed; one that comes no longer as close shows that it may drift."""

from collections.abc import Callable
from math import pi, sin

import pytest

from wheel_slip.close_wheel import CloseWheel
from wheel_slip.speed_filter import SpeedFilter
from wheel_slip.tuning import BoundTuning
from wheel_slip.wheel_bounds import WheelBounds

DT = 0.005
MS = 1_000_000
CLOSE, SPRING_BACK, COMES_AGAIN, STEEPEST = 0.1, 0.1, 1.0, 1.5
SPEED = 20.0
Slip = Callable[[float], float]


def followed(
    slip: Slip, duration: float, dt: float = DT, deceleration: Slip = lambda _t: 3.0
) -> tuple[list[float | None], CloseWheel]:
    wheel = CloseWheel(CLOSE, SPRING_BACK, COMES_AGAIN, STEEPEST)
    times = [k * dt for k in range(round(duration / dt))]
    return [wheel.update(dt, slip(t), SPEED, deceleration(t)) for t in times], wheel


def cycled(closest: Slip) -> Slip:
    """A slip that swings twice a second, up from `closest`, where it stays for a fifth of the time."""
    return lambda t: closest(t) + 0.1 * max(sin(4.0 * pi * t), -0.6) + 0.06


@pytest.mark.parametrize("dt", [0.002, 0.005, 0.02])
@pytest.mark.parametrize(("slip", "left"), [(0.0, 0.1), (-0.03, 0.1), (0.03, 0.07), (0.05, 0.05), (0.08, 0.08)])
def test_a_wheel_that_stays_close_leaves_what_it_may_slip(slip: float, left: float, dt: float) -> None:
    found, _ = followed(lambda _t: slip, 1.0, dt)
    assert found[-1] == pytest.approx(left)
    assert all(each is None for each in found[: round(0.9 * SPRING_BACK / dt)])


@pytest.mark.parametrize("slip", [0.1, 0.12, 0.5, 1.0])
def test_a_wheel_that_is_far_confirms_nothing(slip: float) -> None:
    assert all(each is None for each in followed(lambda _t: slip, 5.0)[0])


def test_a_tyre_that_springs_back_confirms_nothing() -> None:
    """Its wheel turns with the car, and faster, for less than `spring_back`."""
    found, _ = followed(lambda t: -0.1 if t % 0.3 < 0.08 else 0.2, 5.0)
    assert all(each is None for each in found)


def test_wheels_that_come_as_close_as_before_show_no_drift() -> None:
    found, wheel = followed(cycled(lambda _t: 0.03), 8.0)
    assert wheel.drift < 0.03
    assert any(each is not None for each in found[-100:])


@pytest.mark.parametrize("drift", [0.1, 0.15])
def test_a_speed_that_becomes_too_high_shows_as_wheels_that_stay_further_behind(drift: float) -> None:
    """1 m/s^2 of slope at 20 m/s: all slips grow by 5 % in a second."""
    assert followed(cycled(lambda t: 0.03 + min(0.05 * max(t - 2.0, 0.0), drift)), 8.0)[1].drift == pytest.approx(
        drift, abs=0.03
    )


def test_a_speed_that_becomes_too_low_is_not_confirmed_by_wheels_that_come_closer() -> None:
    found, wheel = followed(cycled(lambda t: 0.14 - min(0.04 * max(t - 4.0, 0.0), 0.1)), 10.0)
    assert wheel.drift > 0.07
    assert all(each > 0.07 for each in found[-100:] if each is not None)


@pytest.mark.parametrize(
    ("before", "after", "road", "other"),
    [(0.05, 0.1, 11.3, 7.8), (0.05, 0.1, 7.8, 11.3), (0.05, 0.1, 2.0, 11.3), (0.1, 0.04, 2.0, 11.3)],
)
def test_another_road_at_which_wheels_slip_by_something_else_is_no_drift(
    before: float, after: float, road: float, other: float
) -> None:
    def slip(t: float) -> float:
        return before if t < 3.0 else after

    assert followed(slip, 8.0)[1].drift == pytest.approx(abs(after - before), abs=0.01)
    assert followed(slip, 8.0, deceleration=lambda t: road if t < 3.0 else other)[1].drift < 0.02


def test_a_drift_counts_on_the_next_road_too() -> None:
    def slip(t: float) -> float:
        return 0.02 + 0.05 * min(max(t - 2.0, 0.0), 1.5) - (0.06 if t >= 5.0 else 0.0)

    first = followed(slip, 5.0)[1].drift
    assert first > 0.05
    _, wheel = followed(slip, 10.0, deceleration=lambda t: 11.3 if t < 5.0 else 7.8)
    assert 0.7 * first < wheel.drift <= first


@pytest.mark.parametrize("period", [0.2, 0.5, 0.8])
def test_wheels_that_dive_together_are_no_other_road(period: float) -> None:
    """The whole car slows down less, by more than between two roads, but not for long."""

    def deceleration(t: float) -> float:
        return 3.0 if t % period < 0.6 * period else 1.5

    _, wheel = followed(cycled(lambda t: 0.03 + min(0.05 * max(t - 2.0, 0.0), 0.15)), 8.0, deceleration=deceleration)
    assert wheel.drift == pytest.approx(0.15, abs=0.03)


def test_no_drift_is_faster_than_the_steepest_road() -> None:
    """A wheel that dives, or another road."""
    settled = COMES_AGAIN
    found = [followed(lambda t: 0.12 if t < 2.0 else 0.03, after)[1].drift for after in (0.9, 2.5, 3.0, 4.0)]
    assert found[0] == 0.0
    for drift, after in zip(found[1:], (2.5, 3.0, 4.0), strict=True):
        assert 0.0 < drift <= STEEPEST * (after - settled) / SPEED + 1e-9
    _, dived = followed(lambda t: 1.0 if 2.0 < t < 2.3 else 0.05, 4.0)
    assert dived.drift < STEEPEST * 0.5 / SPEED


def test_a_new_slide_begins_without_memory() -> None:
    _, wheel = followed(cycled(lambda t: 0.02 * t), 8.0)
    assert wheel.drift > 0.05
    wheel.reset()
    assert wheel.drift == wheel.lasted == 0.0
    assert wheel.update(DT, 0.05, SPEED, 3.0) is None


def slid(rim: Slip, duration: float, offset: float = 0.0) -> tuple[SpeedFilter, float]:
    """A car that slows down by 3 m/s^2 from 30 m/s, its wheels' rims at rim(t) of its speed; returns its true speed.

    The accelerometer reads `offset` more from the onset on.
    """
    car = SpeedFilter()
    bounds = WheelBounds(BoundTuning(), 4, 0.015**2, 0.004, 0.6, STEEPEST)
    speed = 30.0
    car.start(speed, 0.01)
    for k in range(round(duration / DT)):
        car.predict(k * round(DT * 1000.0) * MS, -3.0 + offset, observed=False, sliding=True)
        speed -= 3.0 * DT
        rims = [speed * (1.0 - rim(k * DT))] * 4
        bounds.use(car, DT, rims, [], -3.0, 0.1, 1.0)
    return car, speed


def deviations(car: SpeedFilter, speed: float) -> float:
    return abs(car.speed - speed) / car.speed_variance**0.5


@pytest.mark.parametrize("offset", [0.6, -0.6])
@pytest.mark.parametrize("closest", [0.02, 0.06, 0.15])
def test_a_slope_that_began_in_a_slide_is_in_the_deviation_of_the_speed(offset: float, closest: float) -> None:
    for duration in (2.0, 4.0, 6.0):
        car, speed = slid(cycled(lambda _t: closest), duration, offset)
        assert deviations(car, speed) < 1.96


def test_a_steady_road_keeps_the_speed_as_well_known_as_close_wheels_allow() -> None:
    car, speed = slid(cycled(lambda _t: 0.03), 6.0)
    assert deviations(car, speed) < 0.5
    assert car.speed_variance**0.5 < 0.12 * speed


@pytest.mark.parametrize("past", [0.15, 0.3])
def test_wheels_beyond_the_speed_raise_it_and_leave_what_they_may_slip_in_doubt(past: float) -> None:
    car = SpeedFilter()
    bounds = WheelBounds(BoundTuning(), 4, 0.015**2, 0.004, 0.6, STEEPEST)
    car.start(10.0, 4.0)
    rim = 10.0 * (1.0 + past)
    for k in range(100):
        car.predict(k * round(DT * 1000.0) * MS, 0.0, observed=False, sliding=True)
        bounds.use(car, DT, [rim] * 4, [], -3.0, 0.1, 1.0)
    assert abs(car.speed - rim) < 0.03 * rim
    assert car.speed_variance**0.5 > 0.035 * rim
