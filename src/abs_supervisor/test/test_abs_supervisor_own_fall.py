"""A wheel that falls behind its own speed: no slip is needed to see it, and what it gives leave to is little."""

from math import nan

import numpy as np
import pytest

from abs_supervisor.envelope import Envelope
from abs_supervisor.own_fall import OwnFall
from abs_supervisor.release_evidence import Wheel
from abs_supervisor.tuning import EnvelopeTuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import CornerParameters

STEP, DT = 5_000_000, 0.005
RADIUS = 0.3
CORNER = CornerParameters(radius=RADIUS, inertia=1.0, mass=375.0, vertical_load=3678.75)
NOISE = 0.14
"""[rad/s] twice that of section 8.3.2."""
SLOWS = 2.0
"""[m/s^2] of a car on snow."""
ROAD = 300.0
"""[N m] that the road gives to a wheel that slips."""


def falls(shares: list[float], told: float = SLOWS) -> list[bool]:
    """Follow a wheel of a car that slows from 25 m/s, with slips `shares`; `told`: its deceleration as known."""
    own, random, found = OwnFall(3.0), np.random.default_rng(5), []
    for sample, slip in enumerate(shares):
        rim = (25.0 - SLOWS * DT * sample) * (1.0 - slip) + RADIUS * NOISE * float(random.standard_normal())
        own.update(sample * STEP, rim, RADIUS * NOISE, told)
        found.append(own.holds)
    return found


@pytest.mark.parametrize("told", [SLOWS - 0.1, SLOWS, SLOWS + 0.5])
def test_a_wheel_that_keeps_its_slip_does_not_fall_however_long(told: float) -> None:
    assert not any(falls([0.05] * 2000, told))


def test_a_dive_is_seen_and_its_end() -> None:
    slips = [0.04] * 200 + np.linspace(0.04, 0.14, 40).tolist() + np.linspace(0.14, 0.04, 40).tolist() + [0.04] * 40
    found = falls(slips)
    assert not any(found[:215])
    assert all(found[230:250])
    assert not any(found[-40:])


def test_without_the_deceleration_of_the_car_nothing_falls() -> None:
    assert not any(falls(np.linspace(0.0, 0.5, 200).tolist(), nan))


class Bench:
    """The envelope of a wheel whose slip is vague, and a law that always wants a release."""

    def __init__(self, car: float) -> None:
        self.envelope = Envelope(CORNER, ActuatorParameters(), EnvelopeTuning())
        self.car, self.stamp = car, 0

    def at(self, slip: float, count: int, torque: float = ROAD, stddev: float = 0.2) -> Command:
        given = Command.NONE
        for _ in range(count):
            self.stamp += STEP
            speed = self.car * (1.0 - slip) / RADIUS
            wheel = Wheel(speed, slip=slip, slip_stddev=stddev, car_deceleration=0.0, braked=True)
            self.envelope.look(self.stamp, wheel)
            given = self.envelope.judge(self.stamp, Command.DECREASE, self.car, torque, 1000.0)
        return given

    def has_slipped(self) -> None:
        self.at(0.0, 60)
        assert self.at(0.4, 20, stddev=0.003) is Command.DECREASE
        self.at(0.0, 60)


@pytest.mark.parametrize(
    ("car", "share", "slip", "trimmed"),
    [
        (20.0, 1.0, 0.1, True),
        (20.0, 0.9, 0.1, False),  # already below what the road gave
        (20.0, 1.0, 0.02, False),  # no fall
        (3.0, 1.0, 0.1, True),
        (1.8, 1.0, 0.1, False),  # too slow: the slip of a release is needed
    ],
)
def test_a_wheel_that_falls_is_trimmed_down_to_what_the_road_gave(
    car: float, share: float, slip: float, trimmed: bool
) -> None:
    bench = Bench(car)
    bench.has_slipped()
    assert (bench.at(slip, 10, torque=share * ROAD) is Command.DECREASE) == trimmed


def test_a_wheel_that_never_slipped_is_not_trimmed() -> None:
    bench = Bench(20.0)
    bench.at(0.0, 60)
    assert bench.at(0.1, 10) is not Command.DECREASE
