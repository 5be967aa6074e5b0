"""Tyres that are not as calibrated, on a car whose equations are not the estimator's (`corner_sim.car`).

Two minutes: 8 m/s, 2.8 m/s^2 to 22 m/s, cruise, braking at 5 m/s^2 to 8 m/s, and all of it again. The errors count from
the second minute on, after one acceleration and one braking; the intervals from the first valid force on. Tyres differ
in torsional and radial stiffness at once. The calibration is that of the tyres as they should be, the processors are
those of the node.
"""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from friction_msgs.msg import TyreForce, TyreSignals
from geometry_msgs.msg import Vector3
from numpy.typing import NDArray
from rich.progress import Progress
from sensor_msgs.msg import FluidPressure, Imu
from std_msgs.msg import Header

from benchmarks.runner import Row, at_least, at_most
from benchmarks.smart_tyre.runs import PLANT_WHEELS, RING, TRACKER, WHEEL
from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Surroundings
from corner_sim.car.recording import Recording, record
from corner_sim.smart_tyre.drives import CAR
from corner_sim.smart_tyre.tyre_signal import TyreSignalSource
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.ros.processor import TyreProcessor
from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

MINUTE = 60.0
_SPEED = 8.0
_CORNERS = (0.0, 14.0, 14.4, 19.0, 19.4, 42.0, 42.15, 44.71, 44.86, 60.0)
_ACCELERATIONS = (0.0, 0.0, 2.8, 2.8, 0.0, 0.0, -5.0, -5.0, 0.0, 0.0)
_START = 1_000_000_000
"""Stamp of the first sample [ns]."""
_BLOCK = 1000
_NOMINAL_VARIATION = 0.03
"""RMS of the variation of the load by the road, as in the calibration."""
ONE, ALL = "one tyre", "all tyres"
CASES: dict[str, tuple[float, str, float]] = {
    "as calibrated": (1.0, ALL, _NOMINAL_VARIATION),
    **{
        f"stiffness {100.0 * (stiffness - 1.0):+.0f} %, {which}": (stiffness, which, _NOMINAL_VARIATION)
        for stiffness in (0.8, 0.9, 1.1, 1.2)
        for which in (ONE, ALL)
    },
    "load varying by 8 %": (1.0, ALL, 0.08),
    "load varying by 10 %": (1.0, ALL, 0.1),
}
"""Stiffness over that of the calibration, of which tyres, RMS of the load's variation by the road."""
DELAYS = (1, 2)
"""Samples by which the acceleration in the tyre is later than in the calibration."""
_DELAY_ERROR = 0.25
"""Largest error of a change of the delay that is reported, as a share of it."""
LIMITS = {"Fz": 1.3 * 1.1, "Fx": 1.3 * 4.2}
"""RMSE in % of the static load."""
_COVERAGE = 90.0


class Driver:
    """Follows the speeds of the drive with one pedal at a time."""

    def __init__(self, car: CarParameters, duration: float) -> None:
        """Begin; the drive repeats every minute of `duration` [s]."""
        self._p = car
        self._dt = 1e-3
        time = np.arange(0.0, duration + 1.0, self._dt)
        self._wanted = np.interp(time % MINUTE, _CORNERS, _ACCELERATIONS)
        self._speed = _SPEED + np.cumsum(self._wanted) * self._dt

    def _force(self, time: float, car: Car) -> float:
        k = round(time / self._dt)
        p = self._p
        wanted = float(self._wanted[k] + self._speed[k] - car.speed)
        return p.mass * (wanted + p.rolling_resistance * 9.81) + 0.6 * p.drag_area * car.speed**2

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures of the brakes [Pa], all alike."""
        return [max(-self._force(time, car), 0.0) * self._p.radius[0] / sum(self._p.brake_gain)] * 4

    def around(self, time: float, car: Car) -> Surroundings:
        """Engine torque at each rear wheel."""
        return Surroundings(engine_torque=max(0.5 * self._force(time, car) * self._p.radius[2], 1e-3))


def drive(variation: float, seed: int, duration: float = 2.0 * MINUTE) -> Recording:
    """Record the car, its load varying by `variation` RMS, for `duration` [s]."""
    car = CarParameters(radius=(WHEEL.radius,) * 4, relaxation_length=(0.3,) * 4, load_variation=variation)
    driver = Driver(car, duration)
    return record(car, driver, seed, speed=_SPEED, duration=duration, surroundings=driver.around)


@dataclass(frozen=True)
class Judged:
    """Valid revolutions of one wheel, arrays of shape (n,)."""

    time: Array
    """[s]"""
    error: dict[str, Array]
    """Of Fz and Fx [N]."""
    stddev: dict[str, Array]
    delay: float
    """Change of the delay of the acceleration that is reported at the end [s], 0 where none is."""


def judge(recording: Recording, wheel: str, stiffness: float, known: Calibration, seed: int, delay: int = 0) -> Judged:
    """Run the processor of a wheel over a recording, with a tyre that is not as calibrated.

    Args:
        recording: of the car.
        wheel: name of the wheel.
        stiffness: of the tyre over that of the calibration.
        known: the calibration.
        seed: of the signals' noise.
        delay: by how many samples the acceleration in the tyre is later than in the calibration.
    """
    number = CAR.wheel_names.index(wheel)
    ring = replace(
        RING, torsional_stiffness=RING.torsional_stiffness * stiffness, static_load=RING.static_load * stiffness
    )
    source = TyreSignalSource(ring, wheel_seed=PLANT_WHEELS[wheel], noise_seed=10 * seed + number)
    load = recording.vertical_load[:, number]
    truth = {"Fz": load, "Fx": -recording.mu[:, number] * load}
    turning = recording.speed * (1.0 - recording.slip[:, number]) / recording.parameters.radius[number]
    processor = TyreProcessor(wheel, CAR, SmartTyreParameters(), known)
    found: list[tuple[float, TyreForce]] = []
    half = 0.0  # of the time that the last patch took [s]: its force is that of its middle
    for source_topic, message in _messages(recording, wheel, source, turning, truth, delay):
        for topic, answer in processor.process(source_topic, message):
            if topic.endswith("contact_patch") and answer.validity.valid:
                half = 0.5 * answer.length_raw / answer.wheel_speed
            elif topic.endswith("tyre_force") and answer.validity.valid:
                found.append(((to_nanoseconds(answer.header.stamp) - _START) / NANOSECONDS - half, answer))
    time = np.array([when for when, _ in found])
    values = {"Fz": [m.fz for _, m in found], "Fx": [m.fx for _, m in found]}
    stddev = {"Fz": np.array([m.fz_stddev for _, m in found]), "Fx": np.array([m.fx_stddev for _, m in found])}
    error = {name: np.array(values[name]) - np.interp(time, recording.time, truth[name]) for name in truth}
    return Judged(time, error, stddev, processor.delay_change)


def _messages(
    recording: Recording, wheel: str, source: TyreSignalSource, turning: Array, truth: dict[str, Array], delay: int
) -> Iterator[tuple[str, TyreSignals | Imu | FluidPressure]]:
    """Yield topic and message: the blocks of a wheel, each after the sensors of the car up to its end."""
    rate = TRACKER.sample_rate
    sensed = 0
    late = np.zeros(delay)
    for first in range(0, int(recording.time[-1] * rate) - _BLOCK, _BLOCK):
        time = (first + np.arange(_BLOCK)) / rate
        while recording.time[sensed] < time[-1]:
            stamp = from_nanoseconds(_START + round(recording.time[sensed] * NANOSECONDS))
            felt = Vector3(x=float(recording.acceleration[sensed]))
            yield "imu/data", Imu(header=Header(stamp=stamp), linear_acceleration=felt)
            for name, pressure in zip(CAR.wheel_names, recording.brake_pressure[sensed], strict=True):
                yield (
                    f"{name}/brake_pressure",
                    FluidPressure(header=Header(stamp=stamp), fluid_pressure=float(pressure)),
                )
            sensed += 1
        block = source.advance(*(np.interp(time, recording.time, each) for each in (turning, truth["Fx"], truth["Fz"])))
        radial = np.concatenate([late, block.radial_acceleration])
        late = radial[_BLOCK:]
        signals = TyreSignals(
            header=Header(stamp=from_nanoseconds(_START + round(first / rate * NANOSECONDS)), frame_id=wheel),
            wheel=wheel,
            sample_rate=rate,
            first_sample=first,
            encoder_voltage=array("f", block.encoder_voltage.tobytes()),
            radial_acceleration=array("f", radial[:_BLOCK].astype(np.float32).tobytes()),
        )
        yield f"{wheel}/tyre_signals", signals


def rows(known: Calibration, seeds: range, progress: Progress) -> Iterator[Row]:
    """All cases, a row for each axle and quantity; `known` is the calibration of all wheels of the car.

    The left wheels are judged: right ones differ from them in noise alone. The one tyre that differs is the front left.
    """
    task = progress.add_task("gains", total=len(CASES) * len(seeds))
    recordings = {v: [drive(v, seed) for seed in seeds] for v in {case[2] for case in CASES.values()}}
    for case, (stiffness, which, variation) in CASES.items():
        judged: dict[str, list[Judged]] = {"front": [], "rear": []}
        for seed, recording in zip(seeds, recordings[variation], strict=True):
            judged["front"].append(judge(recording, "front_left", stiffness, known, seed))
            if which == ALL:
                judged["rear"].append(judge(recording, "rear_left", stiffness, known, seed))
            progress.advance(task)
        for axle, of_axle in judged.items():
            if of_axle:
                yield from _rows(case, axle, of_axle, with_error=variation < 0.1)
    for delay in DELAYS:
        late = [
            judge(recording, "front_left", 1.0, known, seed, delay)
            for seed, recording in zip(seeds, recordings[_NOMINAL_VARIATION], strict=True)
        ]
        case, change = f"acceleration {1e3 * delay / TRACKER.sample_rate:.1f} ms later", delay / TRACKER.sample_rate
        yield from _rows(case, "front", late, with_error=True)
        error = max(abs(each.delay / change - 1.0) for each in late)
        quantity = {"case": case, "axle": "front", "quantity": "error of the reported change of delay [%]"}
        yield quantity | at_most(100.0 * error, 100.0 * _DELAY_ERROR)


def _rows(case: str, axle: str, judged: list[Judged], *, with_error: bool) -> Iterator[Row]:
    for name, limit in LIMITS.items():
        row = {"case": case, "axle": axle}
        if with_error:
            later = np.concatenate([each.error[name][each.time > MINUTE] for each in judged])
            rmse = 100.0 * float(np.sqrt(np.mean(later**2))) / RING.static_load
            yield row | {"quantity": f"{name} RMSE after a minute [%]"} | at_most(rmse, limit)
        inside = np.concatenate([np.abs(each.error[name]) < 1.96 * each.stddev[name] for each in judged])
        yield row | {"quantity": f"{name} within 95 % interval [%]"} | at_least(100.0 * float(inside.mean()), _COVERAGE)
