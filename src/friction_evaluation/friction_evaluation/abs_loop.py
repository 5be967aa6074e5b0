"""Closed loop from 30 to 5 m/s: plant, shipped friction_slope (no_slip) and abs_supervisor, chapter noise.

The plant is one corner of a car: the chapter's, or the first wheel of --vehicle. The driver's demand is a step to 1.5
times the peak torque. Utilisation is the mean of mu / mu_max from the brake onset to 5 m/s; the ideal stop holds mu_max
all the way. A lock is a slip above 0.95 for 50 ms.

`slip_at_crossing` is off: it does not enter the indicator, and without it the loop needs no wheel_slip.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from friction_msgs.msg import BrakeCommand
from numpy.typing import NDArray
from rich.progress import Progress

from abs_supervisor.parameters import SHIPPED as SHIPPED_SUPERVISOR
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.processor import WheelProcessor as SupervisorProcessor
from corner_sim import messages
from corner_sim.sensors import Measurement
from friction_evaluation.parts import Row
from friction_evaluation.protocol_corner import CAR, VEHICLE
from friction_evaluation.slope_runs import DT, SPEED, STEP
from friction_parameters.values import changed
from friction_runtime.stamps import from_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.processor import WheelProcessor as SlopeProcessor
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.sensor_noise import CHAPTER_NOISE, SensorNoise
from vehicle_models.single_corner import SingleCorner
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

DEMAND_RATIO = 1.5
"""Demand, of the peak torque."""
END_SPEED = 5.0
"""[m/s]"""
_ROLLING = 60
"""Samples of free rolling before the brake: 0.3 s."""
_BUILD_UP = 0.4
"""Time after the onset left out of the second utilisation [s]."""
_LOCK_SLIP = 0.95
_LOCK_TIME = 0.05
"""[s]"""
_FIRST_SEED = 20_000
"""Far from the seeds of the tuning."""
_LONGEST = 12_000
"""Samples after which a run is given up: one minute."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds a surface")
    parser.add_argument(
        "--vehicle", default=VEHICLE, help="vehicle file or name of a shipped one: its first wheel brakes"
    )


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs; return a row per surface."""
    rows: list[Row] = []
    vehicle = load_vehicle(options.vehicle)
    with Progress() as progress:
        task = progress.add_task("closed loop", total=len(TABLE_8_1) * options.seeds)
        for name in TABLE_8_1:
            seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
            found = stops(name, seeds, CHAPTER_NOISE, shipped(), lambda n: progress.advance(task, n), vehicle)
            rows.append(_row(name, found, vehicle))
    return rows


@dataclass
class Stops:
    """Results of n stops, arrays of shape (n,)."""

    utilisation: Array
    """[-]"""
    utilisation_late: Array
    """[-] without the first 0.4 s."""
    distance: Array
    """[m] from brake onset to the end speed."""
    duration: Array
    """[s]"""
    longest_lock: Array
    """[s] longest time with a slip above 0.95."""
    transitions: Array
    release_timeouts: Array
    fail_safes: Array


class Controller:
    """The shipped processors of one run, from its sensors to the command."""

    def __init__(self, vehicle: Vehicle, slope: FrictionSlopeParameters, supervisor: SupervisorParameters) -> None:
        """Build both for the first wheel of a car."""
        self._wheel, self._joint = vehicle.wheels[0].name, vehicle.wheels[0].joint
        self._slope = SlopeProcessor(self._wheel, vehicle, slope)
        self.supervisor = SupervisorProcessor(self._wheel, vehicle, supervisor)

    def command(self, stamp: int, wheel_speed: float, pressure: float, demand: float) -> int:
        """Pass one sample through; return the command for it."""
        time = from_nanoseconds(stamp)
        measured = Measurement(np.array([wheel_speed]), np.array([pressure]), 0.0, 0.0)
        self.supervisor.process("brake_demand", messages.brake_demand(stamp, demand))
        braked = messages.brake_pressure(time, self._wheel, pressure, 0.0)
        self._slope.process(f"{self._wheel}/brake_pressure", braked)
        turning = messages.wheel_states(time, [self._joint], measured)
        for topic, estimate in self._slope.process(WHEEL_STATES, turning):
            for _, answer in self.supervisor.process(topic, estimate):
                if isinstance(answer, BrakeCommand):
                    return int(answer.command)
        raise RuntimeError(f"no brake_command at stamp {stamp} ns")


Parameters = tuple[FrictionSlopeParameters, SupervisorParameters]


def shipped() -> Parameters:
    """Return the shipped parameters of the supervisor's loop, in which it commands."""
    slope = changed(SHIPPED["friction_slope"].parameters, {"no_slip.slip_at_crossing": False})
    return slope, replace(SHIPPED_SUPERVISOR["abs_supervisor"].parameters, shadow=False)


def stops(
    name: str,
    seeds: range,
    noise: SensorNoise,
    parameters: Parameters,
    done: Callable[[int], None] = lambda count: None,
    vehicle: Vehicle = CAR,
) -> Stops:
    """Brake once for each seed, side by side: the plant is one array, each run has its own processors.

    Args:
        name: of the surface.
        seeds: of the sensor noise.
        noise: variances of the sensor noise.
        parameters: of friction_slope and abs_supervisor.
        done: told how many runs have just ended.
        vehicle: its first wheel brakes, with the mass that rests on it.
    """
    count = len(seeds)
    theta = surface(name)
    mu_max = float(burckhardt.peak(theta)[1])
    braked, gain = vehicle.corner(vehicle.wheel_names[0]), vehicle.wheels[0].brake_gain
    demand = DEMAND_RATIO * float(braked.peak_torque(theta))
    corner, actuator = SingleCorner(braked, np.full(count, SPEED)), BrakeActuator(count, DT)
    controllers = [Controller(vehicle, *parameters) for _ in seeds]
    generators = [np.random.default_rng(seed) for seed in seeds]
    torque: Array = np.zeros(count)
    lock: Array = np.zeros(count)
    used, late = np.zeros(count), np.zeros(count)
    result = Stops(*(np.zeros(count) for _ in range(8)))
    running = np.ones(count, dtype=bool)
    start = corner.distance
    for k in range(_LONGEST):
        if k == _ROLLING:
            start = corner.distance
        asked = demand if k >= _ROLLING else 0.0
        commands = np.zeros(count, dtype=np.int64)
        for i in np.flatnonzero(running).tolist():
            draw = generators[i].standard_normal(2)
            speed = corner.wheel_speed[i] + np.sqrt(noise.wheel_speed_variance) * draw[0]
            pressure = (torque[i] + np.sqrt(noise.torque_variance) * draw[1]) / gain
            commands[i] = controllers[i].command((k + 1) * STEP, float(speed), float(pressure), asked / gain)
        after = actuator.step(asked, commands).copy()
        corner.step(torque, after, theta, DT)
        torque = after
        if k < _ROLLING:
            continue
        ratio = np.where(running, corner.friction(theta) / mu_max, 0.0)
        used += ratio
        late += ratio * ((k - _ROLLING) * DT >= _BUILD_UP)
        result.duration += DT * running
        lock = np.where(running & (corner.slip > _LOCK_SLIP), lock + DT, 0.0)
        result.longest_lock = np.maximum(result.longest_lock, lock)
        ended = running & (corner.speed <= END_SPEED)
        result.distance = np.where(ended, corner.distance - start, result.distance)
        running &= ~ended
        done(int(ended.sum()))
        if not running.any():
            break
    result.utilisation = used * DT / result.duration
    result.utilisation_late = late * DT / np.maximum(result.duration - _BUILD_UP, DT)
    for i, controller in enumerate(controllers):
        values = controller.supervisor.health().values
        result.transitions[i] = float(values["transitions"])
        result.release_timeouts[i] = float(values["release time-outs"])
        result.fail_safes[i] = float(values["fail-safes"])
    return result


def _row(name: str, found: Stops, vehicle: Vehicle) -> Row:
    gravity = vehicle.corner(vehicle.wheel_names[0]).gravity
    mu_max = float(burckhardt.peak(surface(name))[1])
    ideal = (SPEED**2 - END_SPEED**2) / (2.0 * mu_max * gravity)
    return {
        "surface": name,
        "method": "no_slip",
        "seeds": found.duration.size,
        "utilisation": float(found.utilisation.mean()),
        "utilisation_worst": float(found.utilisation.min()),
        "utilisation_without_0.4s": float(found.utilisation_late.mean()),
        "runs_with_lock": int((found.longest_lock >= _LOCK_TIME).sum()),
        "longest_lock_ms": 1e3 * float(found.longest_lock.max()),
        "distance_m": float(found.distance.mean()),
        "ideal_distance_m": ideal,
        "distance_ratio": float(found.distance.mean()) / ideal,
        "transitions": float(found.transitions.mean()),
        "release_timeouts": float(found.release_timeouts.mean()),
        "fail_safes": int(found.fail_safes.sum()),
    }
