"""The torque that the road gave to a slipping wheel: a hold near it may pass where slip is vague."""

from math import nan

import pytest

from abs_supervisor.road_torque import RoadTorque

STEP = 5_000_000
RADIUS, INERTIA = 0.3, 1.0
SPEED = 4.0
"""[m/s] of the car, if nothing else is said."""
ROAD = 1000.0
"""[N m] that the road gives at the slip of the release."""


class Wheel:
    """One wheel, sample after sample."""

    def __init__(self) -> None:
        self.road = RoadTorque(RADIUS, INERTIA)
        self.stamp = 0

    def sample(
        self,
        released: bool,
        torque: float = ROAD,
        deceleration: float = 0.0,
        speed: float = SPEED,
        trimmed: bool = False,
    ) -> None:
        self.stamp += STEP
        self.road.update(self.stamp, released, trimmed, torque, deceleration, speed)


def test_without_a_release_no_torque_is_near() -> None:
    wheel = Wheel()
    for _ in range(100):
        wheel.sample(released=False)
    assert not wheel.road.is_near(10.0 * ROAD)


@pytest.mark.parametrize(("share", "near"), [(0.8, False), (0.9, True), (1.0, True), (1.5, True)])
def test_a_torque_is_near_from_a_little_below_what_the_road_gave(share: float, near: bool) -> None:
    wheel = Wheel()
    wheel.sample(released=True)
    assert wheel.road.is_near(share * ROAD) == near


def test_the_torque_that_only_slows_the_wheel_is_not_the_roads() -> None:
    """A dive with 60 m/s^2 takes 200 N m with J/r = 3.33 kg m."""
    wheel = Wheel()
    wheel.sample(released=True, torque=ROAD + 200.0, deceleration=60.0)
    assert wheel.road.is_near(0.86 * ROAD)
    assert not wheel.road.is_near(0.84 * ROAD)


def test_pressure_that_falls_in_a_release_does_not_lower_it_and_the_next_release_counts_anew() -> None:
    wheel = Wheel()
    for torque in (ROAD, 0.8 * ROAD, 0.6 * ROAD):
        wheel.sample(released=True, torque=torque)
    assert not wheel.road.is_near(0.8 * ROAD)
    wheel.sample(released=False)
    wheel.sample(released=True, torque=0.6 * ROAD)
    assert wheel.road.is_near(0.55 * ROAD)


@pytest.mark.parametrize(("speed", "near"), [(4.0, True), (40.0, False), (nan, True)])
def test_it_is_forgotten_after_the_way_to_another_road(speed: float, near: bool) -> None:
    """0.5 s: 2 m, or 20 m."""
    wheel = Wheel()
    wheel.sample(released=True)
    for _ in range(100):
        wheel.sample(released=False, speed=speed)
    assert wheel.road.is_near(ROAD) == near


def test_a_deceleration_that_is_not_known_tells_nothing_of_the_road() -> None:
    wheel = Wheel()
    wheel.sample(released=True, deceleration=nan)
    assert not wheel.road.is_near(ROAD)


def test_reset_forgets_it() -> None:
    wheel = Wheel()
    wheel.sample(released=True)
    wheel.road.reset()
    assert not wheel.road.is_near(ROAD)


@pytest.mark.parametrize(
    ("way", "share", "trimmed"),
    [
        (10.0, 1.4, True),
        (40.0, 1.0, True),
        (40.0, 0.9, False),
        (40.0, 1.4, False),
        (70.0, 1.0, False),
    ],
)
def test_a_torque_that_is_still_the_same_may_be_trimmed_for_longer(way: float, share: float, trimmed: bool) -> None:
    """A wheel creeps from its peak on snow for 50 m."""
    wheel = Wheel()
    wheel.sample(released=True)
    for _ in range(round(way / (20.0 * 0.005))):
        wheel.sample(released=False, speed=20.0)
    assert wheel.road.may_fall(share * ROAD) is trimmed


def test_a_brake_that_had_far_more_since_is_on_another_road() -> None:
    wheel = Wheel()
    wheel.sample(released=True)
    for torque in [ROAD] * 200 + [2.0 * ROAD] * 10 + [ROAD] * 10:
        wheel.sample(released=False, torque=torque, speed=20.0)
    assert not wheel.road.may_fall(ROAD)


@pytest.mark.parametrize(("gains", "slipped"), [(6.0, True), (1.0, False), (-2.0, False)])
def test_a_wheel_that_comes_back_from_a_trim_tells_that_the_road_gives_what_it_gave(
    gains: float, slipped: bool
) -> None:
    """At 20 m/s it has to gain 0.3 m/s; `gains` [m/s^2] for 0.1 s, 50 m after the release."""
    wheel = Wheel()
    wheel.sample(released=True)
    for _ in range(500):
        wheel.sample(released=False, speed=20.0)
    wheel.sample(released=False, speed=20.0, trimmed=True)
    for _ in range(20):
        wheel.sample(released=False, speed=20.0, deceleration=-gains)
    for _ in range(200):
        wheel.sample(released=False, speed=20.0, deceleration=2.0)
    assert wheel.road.may_fall(ROAD) is slipped


def test_near_what_the_road_gave_the_pressure_may_be_held_again_after_such_a_trim() -> None:
    wheel = Wheel()
    wheel.sample(released=True)
    for _ in range(500):
        wheel.sample(released=False, speed=20.0)
    assert not wheel.road.is_near(ROAD)
    wheel.sample(released=False, speed=20.0, trimmed=True)
    for _ in range(20):
        wheel.sample(released=False, speed=20.0, deceleration=-6.0)
    assert wheel.road.is_near(ROAD)


def test_a_wheel_that_comes_back_later_does_not_tell() -> None:
    wheel = Wheel()
    wheel.sample(released=True)
    for _ in range(500):
        wheel.sample(released=False, speed=20.0)
    wheel.sample(released=False, speed=20.0, trimmed=True)
    for deceleration in [2.0] * 60 + [-6.0] * 20 + [2.0] * 140:
        wheel.sample(released=False, speed=20.0, deceleration=deceleration)
    assert not wheel.road.may_fall(ROAD)
