"""`tutorial`: simulates a drive and writes it as a car's logger would, to try import, doctor, process and report on.

A minute of changing speeds on a level road, then a hard stop. The car's file is wrong in two ways: the front left wheel
has a radius 3 % below it, and the pressures are 12 ms old when they are sent.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import WHEELS, CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, SlipCycle, Surroundings
from corner_sim.car.recording import Recording, record
from friction_adapter.sources import INSTALL_LINE
from friction_bags.bag_io.bag_format import BagError
from friction_parameters.parameter import ParameterError
from vehicle_models.constants import AIR_DENSITY, GRAVITY

SMALL_WHEEL = 0.97
"""Radius of the front left wheel over that of the car's file."""
PRESSURE_AGE = 0.012
"""Age of the pressures when they are sent [s]."""
_NOMINAL = 0.3
"""Radius by which the car makes km/h [m]."""
_SEED = 4
_PHASES = ((4.0, 2.2), (1.5, 0.0), (2.5, -2.5), (4.0, 2.0), (1.0, 0.0), (2.5, -4.0), (3.0, 2.5), (2.5, -1.5))
"""Duration [s] and acceleration [m/s^2] of what the driver does, again and again."""
_ROUNDS = 3
_PEDAL = 0.15
"""Time constant of the pedals [s]."""
_BEGIN = 10.0
"""Speed at the begin [m/s]."""
_STOP_FROM, _LATEST = 25.0, 100.0
"""Speed from which the driver stops hard [m/s], and longest drive [s]."""
_START = 1.7e9
"""Time at which the log begins [s]."""
_SPEED_EVERY, _SPEED_NOISE = 10, 0.05
"""Samples between those of the speed sensor, and its noise [m/s]."""


class _Driver:
    """A drive on a level road that a car can be learned from, and a stop through the peak of the friction curve."""

    def __init__(self, parameters: CarParameters) -> None:
        self._parameters = parameters
        self._goals = [phase for _ in range(_ROUNDS) for phase in _PHASES]
        self._until, self._goal, self._now = 0.0, 0.0, 0.0
        self._pressure = 0.0
        self._stop: SlipCycle | None = None

    def surroundings(self, time: float, car: Car) -> Surroundings:
        """Engine at `time` [s]; call it once each step, before `pressure`."""
        if self._stop is not None:
            return Surroundings()
        if time >= self._until:
            duration, self._goal = self._goals.pop(0) if self._goals else (1.0, 2.5)
            self._until = time + duration
        if not self._goals and car.speed > _STOP_FROM:
            self._stop = SlipCycle(self._parameters, Cycling(start=time + 0.7))
        self._now += (self._goal - self._now) * STEP / _PEDAL
        p = self._parameters
        resistance = p.mass * GRAVITY * p.rolling_resistance + 0.5 * AIR_DENSITY * p.drag_area * car.speed**2
        force = p.mass * self._now + resistance
        brakes = self._goal < 0.0
        self._pressure = max(-force * p.radius[1] - 2.0 * p.engine_drag, 0.0) / sum(p.brake_gain) if brakes else 0.0
        return Surroundings(0.0 if brakes else max(0.5 * force * p.radius[2], 0.0))

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s]."""
        return [self._pressure] * 4 if self._stop is None else self._stop.pressure(time, dt, car)


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="directory to make")


def run(args: Namespace) -> int:
    """Write the log with its DBC file, the signal map and the car's file.

    Returns:
        Exit code: 0.

    Raises:
        BagError: the directory exists.
        ParameterError: python-can or cantools is not installed.
        OSError: a file cannot be written.
    """
    can, cantools = _can_packages()
    if args.out.exists():
        raise BagError(f"{args.out} exists")
    args.out.mkdir(parents=True)
    for file in files("friction_bags").joinpath("tutorial").iterdir():
        (args.out / file.name).write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    database = cantools.database.load_file(args.out / "car.dbc")
    with can.Logger(args.out / "drive.blf") as log:
        for time, name, values in frames(drive()):
            message = database.get_message_by_name(name)
            data = message.encode(values)
            log.on_message_received(
                can.Message(timestamp=time, arbitration_id=message.frame_id, is_extended_id=False, data=data, channel=0)
            )
    print(f"{args.out}: {', '.join(sorted(path.name for path in args.out.iterdir()))}")
    return 0


def drive() -> Recording:
    """Drive the car; the truth is in the recording."""
    nominal = CarParameters()
    sensors = SensorParameters(sample_rate=200, pressure_delay=PRESSURE_AGE)
    radius = (SMALL_WHEEL * _NOMINAL, _NOMINAL, _NOMINAL, _NOMINAL)
    car = replace(nominal, radius=radius, relaxation_length=(0.2,) * 4, engine_drag=30.0, sensors=sensors)
    driver = _Driver(car)
    return record(car, driver, _SEED, speed=_BEGIN, duration=_LATEST, surroundings=driver.surroundings)


def frames(recording: Recording) -> Iterator[tuple[float, str, dict[str, float]]]:
    """Yield time [s], name and signals of each frame, in the units of the DBC file."""
    noise = _SPEED_NOISE * np.random.default_rng([_SEED, 9]).normal(size=recording.time.size)
    for k, since in enumerate(recording.time.tolist()):
        time = _START + since
        speeds = np.clip(3.6 * _NOMINAL * recording.wheel_speed[k], 0.0, None)
        yield time, "Wheels", _of_wheels("V", speeds)
        yield time, "Brakes", _of_wheels("P", 1e-5 * recording.brake_pressure[k])
        yield time, "Body", {"LongAcc": float(recording.acceleration[k]) / 9.80665}
        if k % _SPEED_EVERY == 0:
            yield time, "Position", {"Speed": 3.6 * float(recording.speed[k] + noise[k])}


def _of_wheels(letter: str, values: Any) -> dict[str, float]:
    return {f"{letter}_{name}": float(value) for name, value in zip(WHEELS, values, strict=True)}


def _can_packages() -> tuple[Any, Any]:
    try:
        import can
        import cantools
    except ImportError as error:
        raise ParameterError(f"the log is one of a CAN bus, which needs two more packages: {INSTALL_LINE}") from error
    return can, cantools
