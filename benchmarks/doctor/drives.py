"""Drives of `model: car` in ordinary traffic for the doctor, healthy and with injected faults."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import OrdinaryDriver, Surroundings
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES
from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, Recorded, pressure_topic
from vehicle_models.vehicle import Vehicle

_START = 15.0
_SPEED_NOISE = 0.03
"""Noise of the speed sensor [m/s]."""
_TURNING_NOISE = 0.01
"""Noise of the yaw rate [rad/s]."""
_ROADS = ("dry", "wet")
"""Roads on which ordinary driving brakes hard enough to tell gains."""


@dataclass(frozen=True)
class Driven:
    """A drive, and the truth."""

    drive: Drive
    truth: CarParameters
    flat: bool
    """Whether the road has no slope."""
    wheel_age: float
    """Mean age of the wheel speeds at their stamps [s]."""


def driven(vehicle: Vehicle, seed: int, seconds: float, fading: float = 0.0, hot: float = 4e5) -> Driven:
    """Drive a car whose values are spread as its vehicle file states.

    Args:
        vehicle: `compact_car`, around which random_car draws.
        seed: same seed, same car and drive. Odd ones have a flat road, and encoders with teeth.
        seconds: length.
        fading: share of the brake gain that is lost to heat.
        hot: work of a brake at which it is lost [J].
    """
    families = tuple(TYRES)
    family, road = families[seed // 2 % len(families)], _ROADS[seed // 4 % len(_ROADS)]
    flat, teeth = bool(seed % 2), 48 if seed // 2 % 2 else 0
    car = random_car(seed, road, family).parameters
    sensors = replace(car.sensors, encoder_teeth=teeth, acceleration_stddev=0.1)
    car = replace(car, slope=0.0, sensors=sensors, fading=fading, fading_energy=hot)
    driver = OrdinaryDriver(car, seed)
    every = round(1.0 / (STEP * sensors.sample_rate))
    turning: list[float] = []

    def around(time: float, body: Car) -> Surroundings:
        found = driver.surroundings(time, body)
        turning.append(found.curvature * body.speed)
        return replace(found, slope=0.0) if flat else found

    recording = record(car, driver, seed, speed=_START, duration=seconds, surroundings=around)
    yaw_rate = np.resize(turning[::every], recording.time.size)  # the last sample has no step behind it
    omega = np.maximum(recording.wheel_speed, 1.0)
    # an encoder's speed is the mean over its interval, which ends up to a tooth before the stamp
    age = 0.5 / sensors.sample_rate + float(np.mean(np.pi / teeth / omega)) if teeth else 0.0
    return Driven(as_drive(recording, yaw_rate, vehicle, seed), car, flat, age)


def as_drive(recording: Recording, yaw_rate: Array, vehicle: Vehicle, seed: int) -> Drive:
    """Return the topics of a recording, a speed sensor at 20 Hz among them.

    Args:
        recording: of N samples.
        yaw_rate: truth [rad/s], (N,).
        vehicle: the car as its file says.
        seed: of the noise that the recording lacks.
    """
    count = recording.time.size
    time = recording.time

    def topic(values: Array) -> Recorded:
        return Recorded(time, time, np.asarray(values, dtype=np.float64).reshape(count, -1))

    turning = yaw_rate + _TURNING_NOISE * np.random.default_rng([seed, 7]).normal(size=count)
    lateral = yaw_rate * recording.speed
    zero = 0.02 * np.random.default_rng([seed, 6]).normal(size=(count, 2))
    slow = slice(None, None, max(round(0.05 / (time[1] - time[0])), 1))
    noise = _SPEED_NOISE * np.random.default_rng([seed, 5]).normal(size=time[slow].size)
    measured = (recording.speed[slow] + noise)[:, None]
    topics = {
        WHEEL_STATES: topic(recording.wheel_speed),
        IMU: topic(np.column_stack([recording.acceleration, lateral + zero[:, 0], 9.81 + zero[:, 1], turning])),
        SPEED: Recorded(time[slow], time[slow], measured),
    }
    for i, name in enumerate(vehicle.wheel_names):
        topics[pressure_topic(name)] = topic(recording.brake_pressure[:, i])
    return Drive(vehicle, topics, ())


Change = Callable[[Drive], Drive]


@dataclass(frozen=True)
class InjectedFault:
    """A fault and its name in the report."""

    name: str
    change: Change
    check: str
    """Check that must find it."""
    subject: str
    """What it must find it in."""
    word: str = ""
    """What its sentence must hold."""


def _edit(topic: str, edit: Callable[[Recorded], Recorded]) -> Change:
    return lambda drive: replace(drive, topics={**drive.topics, topic: edit(drive.topics[topic])})


def _scaled(topic: str, factor: float | Array, offset: float = 0.0) -> Change:
    return _edit(topic, lambda r: replace(r, values=r.values * factor + offset))


def _late(topic: str, seconds: float) -> Change:
    return _edit(topic, lambda r: replace(r, stamp=r.stamp + seconds))


def _column(topic: str, column: int, change: Callable[[Array], Array]) -> Change:
    def edit(recorded: Recorded) -> Recorded:
        values = recorded.values.copy()
        values[:, column] = change(values[:, column])
        return replace(recorded, values=values)

    return _edit(topic, edit)


def _copied(topic: str, source: int, target: int) -> Change:
    def edit(recorded: Recorded) -> Recorded:
        values = recorded.values.copy()
        values[:, target] = values[:, source]
        return replace(recorded, values=values)

    return _edit(topic, edit)


def _exchanged(order: Sequence[int]) -> Change:
    return _edit(WHEEL_STATES, lambda r: replace(r, values=r.values[:, order]))


def _lacking_teeth(wheel: int, missing: int, teeth: int) -> Change:
    """Once a revolution the edges of some teeth do not come, and the speed of that sample lacks their angle."""

    def edit(recorded: Recorded) -> Recorded:
        values = recorded.values.copy()
        steps = np.diff(recorded.stamp, prepend=2.0 * recorded.stamp[0] - recorded.stamp[1])
        turns = np.cumsum(values[:, wheel] * steps) / (2.0 * np.pi)
        gaps = np.diff(np.floor(turns), prepend=0.0)
        values[:, wheel] -= gaps * missing * 2.0 * np.pi / teeth / steps
        return replace(recorded, values=values)

    return _edit(WHEEL_STATES, edit)


def _pressures(change: Callable[[str], Change]) -> Change:
    def edit(drive: Drive) -> Drive:
        for name in drive.vehicle.wheel_names:
            drive = change(pressure_topic(name))(drive)
        return drive

    return edit


def _kept(topic: str, keep: Callable[[Recorded], NDArray[np.bool_]]) -> Change:
    def edit(recorded: Recorded) -> Recorded:
        rows = keep(recorded)
        return Recorded(recorded.stamp[rows], recorded.arrival[rows], recorded.values[rows])

    return _edit(topic, edit)


def _without(topic: str) -> Change:
    return lambda drive: replace(drive, topics={k: v for k, v in drive.topics.items() if k != topic})


def _turned(drive: Drive) -> Drive:
    return _edit(IMU, lambda r: replace(r, values=r.values[:, [1, 0, 2, 3]]))(drive)


def _jumping_back(recorded: Recorded) -> Recorded:
    stamps = recorded.stamp.copy()
    stamps[500::1000] -= 0.1
    return replace(recorded, stamp=stamps)


_FRONT_LEFT = pressure_topic("front_left")
FAULTS: dict[str, InjectedFault] = {
    fault.name: fault
    for fault in (
        InjectedFault("wheels in km/h", _scaled(WHEEL_STATES, 3.6 * 0.3), "unit", WHEEL_STATES, "km/h"),
        InjectedFault("wheels in rpm", _scaled(WHEEL_STATES, 30.0 / np.pi), "unit", WHEEL_STATES, "rpm"),
        InjectedFault("wheels in m/s", _scaled(WHEEL_STATES, 0.3), "unit", WHEEL_STATES, "m/s"),
        InjectedFault(
            "wheel backwards", _scaled(WHEEL_STATES, np.array([1.0, 1.0, -1.0, 1.0])), "sign", "rear_left", "backwards"
        ),
        InjectedFault("wheel copied", _copied(WHEEL_STATES, 0, 1), "duplicate", "front_right", "front_left"),
        InjectedFault("wheel stuck", _column(WHEEL_STATES, 3, lambda v: 7.0 + 0.0 * v), "wheel", "rear_right", "never"),
        InjectedFault("front wheels exchanged", _exchanged([1, 0, 2, 3]), "exchanged", "front_left", "front_right"),
        InjectedFault("axles exchanged", _exchanged([2, 3, 0, 1]), "exchanged", WHEEL_STATES, "front and rear"),
        InjectedFault("a tooth missing", _lacking_teeth(2, 1, 48), "teeth", "rear_left", "once in every revolution"),
        InjectedFault(
            "radius -3 %", _scaled(WHEEL_STATES, np.array([1.0 / 0.97, 1.0, 1.0, 1.0])), "radius", "front_left", "-"
        ),
        InjectedFault(
            "radius +2 %", _scaled(WHEEL_STATES, np.array([1.0, 1.0, 1.0, 1.0 / 1.02])), "radius", "rear_right", "+"
        ),
        InjectedFault("accelerometer in g", _scaled(IMU, 1.0 / 9.81), "unit", IMU, "g"),
        InjectedFault("accelerometer backwards", _scaled(IMU, -1.0), "sign", IMU, "backwards"),
        InjectedFault("accelerometer along y", _turned, "mounting", IMU, "y"),
        InjectedFault("accelerometer scale 0.9", _scaled(IMU, 0.9), "scale", IMU),
        InjectedFault("accelerometer bias 0.9 m/s^2", _scaled(IMU, 1.0, 0.9), "bias", IMU),
        InjectedFault("accelerometer 40 ms late", _late(IMU, 0.04), "skew", IMU),
        InjectedFault("no accelerometer", _without(IMU), "topic", IMU, "no message"),
        InjectedFault("accelerometer in steps", _edit(IMU, lambda r: replace(r, values=np.round(r.values / 0.4) * 0.4)),
                "resolution", IMU, "steps"),
        InjectedFault("pressure in bar", _pressures(lambda t: _scaled(t, 1e-5)), "unit", _FRONT_LEFT, "bar"),
        InjectedFault("pressure in kPa", _pressures(lambda t: _scaled(t, 1e-3)), "unit", _FRONT_LEFT, "kPa"),
        InjectedFault("pressure backwards", _scaled(_FRONT_LEFT, -1.0), "sign", _FRONT_LEFT, "falls"),
        InjectedFault("pressure that does not brake",
                _edit(_FRONT_LEFT, lambda r: replace(r, values=np.roll(r.values, r.values.size // 3, axis=0))),
                "pressure", _FRONT_LEFT, "does not brake"),
        InjectedFault("pressure offset 3 bar", _scaled(_FRONT_LEFT, 1.0, 3e5), "pressure offset", _FRONT_LEFT),
        InjectedFault("pressure 60 ms late", _pressures(lambda t: _late(t, 0.06)), "skew", _FRONT_LEFT),
        InjectedFault("gain 1.6 times", _pressures(lambda t: _scaled(t, 1.0 / 1.6)), "gain", "brakes"),
        InjectedFault(
            "wheels with gaps", _kept(WHEEL_STATES, lambda r: r.stamp % 20.0 > 0.4), "topic", WHEEL_STATES, "gaps"
        ),
        InjectedFault("stamps go back", _edit(IMU, _jumping_back), "topic", IMU, "back"),
        InjectedFault("speed in km/h", _scaled(SPEED, 3.6), "unit", SPEED, "km/h"),
        InjectedFault("speed 80 ms late", _late(SPEED, 0.08), "skew", SPEED),
    )
}  # fmt: skip
PAIRS = (
    ("wheels in km/h", "pressure in bar"),
    ("wheels in rpm", "accelerometer backwards"),
    ("accelerometer in g", "radius -3 %"),
    ("radius -3 %", "pressure 60 ms late"),
    ("accelerometer backwards", "pressure in kPa"),
    ("wheel backwards", "speed in km/h"),
    ("accelerometer 40 ms late", "pressure 60 ms late"),
    ("gain 1.6 times", "radius +2 %"),
    ("wheels with gaps", "pressure in bar"),
    ("speed 80 ms late", "accelerometer scale 0.9"),
    ("pressure backwards", "wheels in m/s"),
    ("stamps go back", "radius +2 %"),
    ("pressure that does not brake", "accelerometer in g"),
    ("front wheels exchanged", "pressure 60 ms late"),
    ("a tooth missing", "wheels in km/h"),
)
"""Pairs of faults."""
