"""Troubles that are put into a sound drive, and what the doctor has to name them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, Recorded, pressure_topic

Change = Callable[[Drive], Drive]


@dataclass(frozen=True)
class Trouble:
    """A trouble and its name in the report."""

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
TROUBLES: dict[str, Trouble] = {
    trouble.name: trouble
    for trouble in (
        Trouble("wheels in km/h", _scaled(WHEEL_STATES, 3.6 * 0.3), "unit", WHEEL_STATES, "km/h"),
        Trouble("wheels in rpm", _scaled(WHEEL_STATES, 30.0 / np.pi), "unit", WHEEL_STATES, "rpm"),
        Trouble("wheels in m/s", _scaled(WHEEL_STATES, 0.3), "unit", WHEEL_STATES, "m/s"),
        Trouble(
            "wheel backwards", _scaled(WHEEL_STATES, np.array([1.0, 1.0, -1.0, 1.0])), "sign", "rear_left", "backwards"
        ),
        Trouble("wheel copied", _copied(WHEEL_STATES, 0, 1), "duplicate", "front_right", "front_left"),
        Trouble("wheel stuck", _column(WHEEL_STATES, 3, lambda v: 7.0 + 0.0 * v), "wheel", "rear_right", "never"),
        Trouble("front wheels exchanged", _exchanged([1, 0, 2, 3]), "exchanged", "front_left", "front_right"),
        Trouble("axles exchanged", _exchanged([2, 3, 0, 1]), "exchanged", WHEEL_STATES, "front and rear"),
        Trouble("a tooth missing", _lacking_teeth(2, 1, 48), "teeth", "rear_left", "once in every revolution"),
        Trouble(
            "radius -3 %", _scaled(WHEEL_STATES, np.array([1.0 / 0.97, 1.0, 1.0, 1.0])), "radius", "front_left", "-"
        ),
        Trouble(
            "radius +2 %", _scaled(WHEEL_STATES, np.array([1.0, 1.0, 1.0, 1.0 / 1.02])), "radius", "rear_right", "+"
        ),
        Trouble("accelerometer in g", _scaled(IMU, 1.0 / 9.81), "unit", IMU, "g"),
        Trouble("accelerometer backwards", _scaled(IMU, -1.0), "sign", IMU, "backwards"),
        Trouble("accelerometer along y", _turned, "mounting", IMU, "y"),
        Trouble("accelerometer scale 0.9", _scaled(IMU, 0.9), "scale", IMU),
        Trouble("accelerometer offset 0.9 m/s^2", _scaled(IMU, 1.0, 0.9), "offset", IMU),
        Trouble("accelerometer 40 ms late", _late(IMU, 0.04), "skew", IMU),
        Trouble("no accelerometer", _without(IMU), "topic", IMU, "no message"),
        Trouble("accelerometer in steps", _edit(IMU, lambda r: replace(r, values=np.round(r.values / 0.4) * 0.4)),
                "resolution", IMU, "steps"),
        Trouble("pressure in bar", _pressures(lambda t: _scaled(t, 1e-5)), "unit", _FRONT_LEFT, "bar"),
        Trouble("pressure in kPa", _pressures(lambda t: _scaled(t, 1e-3)), "unit", _FRONT_LEFT, "kPa"),
        Trouble("pressure backwards", _scaled(_FRONT_LEFT, -1.0), "sign", _FRONT_LEFT, "falls"),
        Trouble("pressure that does not brake",
                _edit(_FRONT_LEFT, lambda r: replace(r, values=np.roll(r.values, r.values.size // 3, axis=0))),
                "pressure", _FRONT_LEFT, "does not brake"),
        Trouble("pressure offset 3 bar", _scaled(_FRONT_LEFT, 1.0, 3e5), "pressure offset", _FRONT_LEFT),
        Trouble("pressure 60 ms late", _pressures(lambda t: _late(t, 0.06)), "skew", _FRONT_LEFT),
        Trouble("gain 1.6 times", _pressures(lambda t: _scaled(t, 1.0 / 1.6)), "gain", "brakes"),
        Trouble("wheels with gaps", _kept(WHEEL_STATES, lambda r: r.stamp % 20.0 > 0.4), "topic", WHEEL_STATES, "gaps"),
        Trouble("stamps go back", _edit(IMU, _jumping_back), "topic", IMU, "back"),
        Trouble("speed in km/h", _scaled(SPEED, 3.6), "unit", SPEED, "km/h"),
        Trouble("speed 80 ms late", _late(SPEED, 0.08), "skew", SPEED),
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
"""Pairs of troubles."""
