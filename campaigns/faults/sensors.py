"""Faults of wheel speed sensors and of the accelerometer."""

from collections.abc import Callable, Sequence
from math import nan, sin, sqrt
from typing import Any

from benchmarks.protocol import DT
from campaigns.faults.case import Arrival, Fault, Site, at_once, changed, keeping, silent
from corner_sim.sensors import CHAPTER_NOISE
from friction_runtime.wheel_inputs import WHEEL_STATES

_FLICKER_SHARE = 0.1
"""Share of the samples that read 0."""
_NOISE_FACTOR = 3.0
"""Standard deviation in units of the chapter's."""
_RIPPLE = 0.02
"""Amplitude of the ripple relative to the speed; one period a revolution."""

Change = Callable[[float], float]
"""Measured speed of one wheel [rad/s] to what the faulty sensor says."""


def _of_places(places: Sequence[int], changes: Sequence[Change]) -> Fault:
    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic == WHEEL_STATES:
            for place, change in zip(places, changes, strict=True):
                message.velocity[place] = change(message.velocity[place])
        return at_once(topic, message)

    return pass_on


def _of_first_wheel(change: Change) -> Fault:
    return _of_places((0,), (change,))


def dead(site: Site) -> Fault:
    """It reads 0."""
    return _of_first_wheel(lambda speed: 0.0)


def stuck(site: Site) -> Fault:
    """It keeps the speed that it had."""
    return _of_first_wheel(keeping())


def flickering(site: Site) -> Fault:
    """It reads 0 on random samples."""
    return _of_first_wheel(lambda speed: 0.0 if site.random.random() < _FLICKER_SHARE else speed)


def biased(site: Site, factor: float) -> Fault:
    """It reads a multiple of the speed."""
    return _of_first_wheel(lambda speed: factor * speed)


def not_a_number(site: Site) -> Fault:
    """It reads NaN."""
    return _of_first_wheel(lambda speed: nan)


def missing(site: Site) -> Fault:
    """wheel_states comes without this wheel."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic == WHEEL_STATES:
            message.name, message.velocity = message.name[1:], message.velocity[1:]
        return at_once(topic, message)

    return pass_on


def noisy(site: Site) -> Fault:
    """All wheels have three times the chapter's noise."""
    added = sqrt((_NOISE_FACTOR**2 - 1.0) * CHAPTER_NOISE.wheel_speed_variance)
    places = range(len(site.vehicle.wheels))
    return _of_places(places, [lambda speed: speed + added * float(site.random.standard_normal())] * len(places))


def rippled(site: Site) -> Fault:
    """All wheels read 2 % too much and too little once a revolution."""
    places = range(len(site.vehicle.wheels))
    return _of_places(places, [_ripple(float(site.random.uniform(0.0, 6.28))) for _ in places])


def _ripple(phase: float) -> Change:
    angle = [phase]

    def change(speed: float) -> float:
        angle[0] += speed * DT
        return speed * (1.0 + _RIPPLE * sin(angle[0]))

    return change


_TOPICS = ("imu/data",)
_BIAS = 1.0
"""[m/s^2]"""


def imu_dead(site: Site) -> Fault:
    """Nothing comes."""
    return silent(_TOPICS)


def imu_biased(site: Site) -> Fault:
    """It reads 1 m/s^2 too much."""

    def change(message: Any) -> None:
        message.linear_acceleration.x += _BIAS

    return changed(_TOPICS, change)


def imu_stuck(site: Site) -> Fault:
    """It keeps the value that it had, under stamps that go on."""
    read = keeping()

    def change(message: Any) -> None:
        message.linear_acceleration.x = read(message.linear_acceleration.x)

    return changed(_TOPICS, change)
