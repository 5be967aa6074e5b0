"""Drives of the independent plant on which speed without a speed sensor is judged: stops, hills, locks, spins.

The estimator has the vehicle file. The plant's radii, pitch, and scale, bias and delay of its accelerometer have the
standard deviations of this file; a perturbation by name is set on top. Each is one error over a whole drive, so that
with few random cars chance would decide a row. The errors of consecutive seeds are spread evenly instead (Kronecker's
sequence: multiples of an irrational ratio, modulo 1, are the probabilities of the errors).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import sqrt
from statistics import NormalDist
from typing import Any

import numpy as np

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling, OrdinaryDriver, SlipCycle, Surroundings, peak_pressures
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Prescription, Recording, record
from corner_sim.car.tyres import TYRES
from vehicle_models.vehicle import Vehicle

BEGIN = 6.0
"""Begin of braking, slope or spin [s]: before it the car rolls and the bias can be learned."""
_RISE = 0.5
"""Time in which a gentle brake is applied [s]."""
_DURATION = 14.0
"""Longest drive [s]."""
_FORWARD, _REVERSE = 25.0, 10.0
"""Speeds at the start [m/s]."""
_STEEP = 0.1
_HILL = 0.06
"""Sines of slopes: that of a step, and that of a hill that comes within a second."""
_LOCKED = 3.0
"""Time for which all wheels are locked [s]."""
_SPIN = (270.0, 1.5)
"""Torque at each rear wheel [N m], beyond the grip of snow, and its time [s]."""
_EVERY, _ROLLS, _OPENS = 2.0, 0.35, 0.05
"""Time from one wheel that is released to the next, for which it is, and in which its brake opens [s]."""
_ORDINARY = 60.0
"""Length of an ordinary drive [s]."""
_SPREAD: Mapping[str, float] = {
    "radius": (sqrt(5.0) - 1.0) / 2.0,
    "pitch_gain": sqrt(2.0),
    "bias": sqrt(3.0),
    "scale": sqrt(7.0),
    "delay": sqrt(11.0),
}
"""Irrational share by which the probability of each deviation goes on from car to car."""
Around = Callable[[float, Car], Surroundings]


@dataclass(frozen=True)
class Held:
    """A share of the pressures of the peak that is applied within a rise and held."""

    parameters: CarParameters
    share: float
    until: float = np.inf
    """Release [s]."""

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], shape (4,)."""
        applied = min(max((time - BEGIN) / _RISE, 0.0), 1.0) if time < self.until else 0.0
        return [applied * self.share * each for each in peak_pressures(self.parameters)]


@dataclass(frozen=True)
class Referred:
    """Slips cycled through the peak; one rear wheel after the other is released for a moment, to roll."""

    parameters: CarParameters
    cycle: SlipCycle

    def pressure(self, time: float, dt: float, car: Car) -> list[float]:
        """Pressures [Pa] of the step of dt [s] from `time` [s], shape (4,)."""
        pressures = self.cycle.pressure(time, dt, car)
        turn, since = divmod(time - BEGIN, _EVERY)
        if turn >= 0.0 and since > _EVERY - _ROLLS:
            wheel = 2 + int(turn) % 2
            fall = dt / _OPENS * peak_pressures(self.parameters)[wheel]
            # the cycle goes on from there
            pressures[wheel] = max(pressures[wheel] - fall, 0.0)
        return pressures


@dataclass(frozen=True)
class Case:
    """What is special about a drive."""

    family: str = "burckhardt"
    road: str = "dry"
    share: float | None = None
    """Share of the peak's pressures of a gentle stop; None: the slips are cycled through the peak."""
    perturbation: Mapping[str, Any] | None = None
    """Parameters of car or sensors in place of the drawn ones."""
    around: Around | None = None
    until: float = np.inf
    """End of braking [s]."""
    heard_from: float = 0.0
    """Before it the estimator is not there [s]: it starts beside a car that moves."""
    referred: bool = False
    """Whether a rear wheel is released now and then, so that it rolls."""
    in_reverse: bool = False
    """Whether the same motion is the other way round, with the rear axle in front."""

    @property
    def edges(self) -> bool:
        """Whether the wheel speeds are from the edges of an encoder, and the estimator knows it."""
        return self.teeth > 0

    @property
    def teeth(self) -> int:
        """Teeth of that encoder, missing ones included; 0: none."""
        return int((self.perturbation or {}).get("encoder_teeth", 0))

    @property
    def missing_teeth(self) -> int:
        """Teeth that its ring lacks, which the estimator knows."""
        return int((self.perturbation or {}).get("missing_teeth", 0))


def _hill(sine: float) -> Around:
    return lambda time, car: Surroundings(slope=sine * min(max(time - BEGIN - _RISE, 0.0), 1.0))


def _step(sine: float) -> Around:
    return lambda time, car: Surroundings(slope=sine if time > BEGIN + 2.0 * _RISE else 0.0)


def _spin(time: float, car: Car) -> Surroundings:
    torque, lasting = _SPIN
    return Surroundings(engine_torque=torque if BEGIN < time < BEGIN + lasting else 0.0)


_PERTURBATIONS: Mapping[str, Mapping[str, Any]] = {
    "scale +3 %": {"acceleration_scale": 1.03},
    "scale -3 %": {"acceleration_scale": 0.97},
    "pitch as the file": {"pitch_gain": 0.0026},
    "no pitch": {"pitch_gain": 0.0},
    "bias 0.5 m/s^2": {"acceleration_bias": 0.5},
    "accelerometer 10 ms late": {"acceleration_delay": 0.01},
    "48 teeth at 200 Hz": {"encoder_teeth": 48},
    "48 teeth at 50 Hz": {"encoder_teeth": 48, "sample_rate": 50},
    "60-2 teeth at 200 Hz": {"encoder_teeth": 60, "missing_teeth": 2},
    "60-2 teeth at 50 Hz": {"encoder_teeth": 60, "missing_teeth": 2, "sample_rate": 50},
    "radius -1 %": {"radius": (0.297,) * 4},
}


def cases() -> dict[str, Case]:
    """Return all drives by name."""
    found: dict[str, Case] = {}
    for family, roads in TYRES.items():
        for road in roads:
            for share in (0.5, 0.8, 0.9, 0.95):
                found[f"{family}, {road}, at {share:.0%} of the peak"] = Case(family, road, share)
            found[f"{family}, {road}, through the peak"] = Case(family, road)
    for name, perturbation in _PERTURBATIONS.items():
        found[f"{name}, at half of the peak"] = Case(share=0.5, perturbation=perturbation)
        found[f"{name}, through the peak"] = Case(perturbation=perturbation)
    for name, around in (
        ("hill of 6 % in 1 s", _hill(_HILL)),
        ("step of +10 %", _step(_STEEP)),
        ("step of -10 %", _step(-_STEEP)),
    ):
        found[f"{name}, coasting"] = Case(share=0.0, around=around)
        found[f"{name}, at half of the peak"] = Case(share=0.5, around=around)
        found[f"{name}, through the peak"] = Case(around=around)
    for road in ("dry", "snow"):
        found[f"four wheels locked for 3 s, {road}"] = Case(road=road, share=2.0, until=BEGIN + _LOCKED)
    for name, held, heard_from in (
        ("rolling", 0.5, BEGIN - 2.0),
        ("braked at half of the peak", 0.5, BEGIN + 1.0),
        ("braked through the peak", None, BEGIN + 0.5),
    ):
        found[f"start in motion, {name}"] = Case(share=held, heard_from=heard_from)
    found["stop in reverse"] = Case(share=0.5, in_reverse=True)
    for family in TYRES:
        for sine in (_HILL, -_HILL):
            name = f"hill of {100.0 * sine:+.0f} % on snow, through the peak, {family}"
            found[name] = Case(family, "snow", around=_hill(sine))
        name = f"hill of 6 % on snow, a rear wheel released every 2 s, {family}"
        found[name] = Case(family, "snow", around=_hill(_HILL), referred=True)
        found[f"driven wheels spin on snow, {family}"] = Case(family, "snow", share=0.0, around=_spin)
    return found


def drive(case: Case, vehicle: Vehicle, seed: int) -> Recording:
    """Drive one case with a car that differs from its vehicle file by the deviations stated there.

    What is recorded of it is what speed and slip are judged by: time, wheel_speed, brake_pressure, acceleration, speed,
    slip.
    """
    car = differing(case, vehicle, seed)
    pressures: Prescription
    if case.share is not None:
        pressures = Held(car, case.share, case.until)
    else:
        cycle = SlipCycle(car, Cycling(start=BEGIN))
        pressures = Referred(car, cycle) if case.referred else cycle
    speed = _REVERSE if case.in_reverse else _FORWARD
    run = record(car, pressures, seed, speed=speed, duration=_DURATION, surroundings=case.around)
    heard = run.time >= case.heard_from
    sign = -1.0 if case.in_reverse else 1.0
    return replace(
        run,
        time=run.time[heard],
        wheel_speed=sign * run.wheel_speed[heard],
        brake_pressure=run.brake_pressure[heard],
        acceleration=sign * run.acceleration[heard],
        speed=sign * run.speed[heard],
        slip=run.slip[heard],
    )


def ordinary_drive(seed: int) -> Recording:
    """Drive a random car through ordinary traffic; roads and families take turns."""
    families = tuple(TYRES)
    family = families[seed % len(families)]
    roads = tuple(TYRES[family])
    car = replace(random_car(seed, roads[seed // len(families) % len(roads)], family).parameters, slope=0.0)
    driver = OrdinaryDriver(car, seed)
    return record(car, driver, seed, speed=15.0, duration=_ORDINARY, surroundings=driver.surroundings)


def deviates(seed: int) -> dict[str, float]:
    """Return by how many of its deviations a car differs from its vehicle file, by name; `seed` from 0 on."""
    return {name: NormalDist().inv_cdf((0.5 + (seed + 1) * share) % 1.0) for name, share in _SPREAD.items()}


def differing(case: Case, vehicle: Vehicle, seed: int) -> CarParameters:
    """Return a car that differs from its vehicle file by the deviations stated there."""
    accelerometer, wheel = vehicle.accelerometer, vehicle.wheels[0]
    of_car = deviates(seed)

    def around(part: Any, name: str) -> float:
        return float(getattr(part, name) + part.deviations[name].stddev * of_car[name])

    values: dict[str, Any] = {
        "radius": (around(wheel, "radius"),) * 4,
        "pitch_gain": around(accelerometer, "pitch_gain"),
        "acceleration_bias": around(accelerometer, "bias"),
        "acceleration_scale": around(accelerometer, "scale"),
        "acceleration_delay": max(around(accelerometer, "delay"), 0.0),
        **(case.perturbation or {}),
    }
    nominal = CarParameters(relaxation_length=(0.3,) * 4, damper_share=0.5)
    of_sensors = {name: values.pop(name) for name in list(values) if hasattr(nominal.sensors, name)}
    sensors = replace(nominal.sensors, acceleration_stddev=0.1, **of_sensors)
    return replace(nominal, tyres=(TYRES[case.family][case.road],) * 4, sensors=sensors, **values)
