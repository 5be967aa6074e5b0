"""Emergency stops of one corner: perturbations, road, plant, the loop to standstill and the longest lock."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.protocol import CORNER, DT, SPEED
from corner_sim.corner import SingleCorner
from corner_sim.road import Road
from corner_sim.sensors import CHAPTER_NOISE, SensorNoise
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator
from vehicle_models.vehicle import CornerParameters, Vehicle

Array = NDArray[np.float64]

_LOWEST, _HIGHEST = 1.0, 14.0
"""[Hz] of a wheel load on a rough road."""
_TONES = 27


@dataclass(frozen=True)
class Perturbation:
    """A disturbance of the plant; the defaults disturb nothing."""

    name: str = "none"
    noise: float = 1.0
    """Standard deviations of wheel speed and pressure over the chapter's."""
    gain: float = 1.0
    """Brake torque over that of the vehicle file."""
    mass: float = 1.0
    """Mass, and the load with it, over that of the vehicle file."""
    radius: float = 1.0
    """Over that of the vehicle file."""
    delay: float = 0.0
    """More delay of the hydraulics [s]."""
    apply_rate: float = 1.0
    """Rate of rise over that of the parameters."""
    load_variation: float = 0.0
    """Standard deviation of the wheel load over its mean, 1 to 14 Hz."""
    fading: float = 0.0
    """Share of the brake torque that is lost in a second [1/s]."""
    relaxation_length: float = 0.0
    """Of the tyres [m]; 0: that of the vehicle file. The single corner has none."""
    hill: float = 0.0
    """Sine of the slope that comes within 30 m soon after the onset. The single corner has none."""

    @property
    def of_vehicle(self) -> bool:
        """Whether the car differs from its vehicle file."""
        return (self.gain, self.mass, self.radius, self.delay) != (1.0, 1.0, 1.0, 0.0)

    def corner(self, nominal: CornerParameters) -> CornerParameters:
        """Return the corner that brakes, of the one in the vehicle file."""
        return replace(
            nominal,
            mass=self.mass * nominal.mass,
            vertical_load=self.mass * nominal.vertical_load,
            radius=self.radius * nominal.radius,
        )

    def vehicle(self, nominal: Vehicle) -> Vehicle:
        """Return the car that brakes, of the one in the vehicle file."""
        wheels = tuple(
            replace(
                wheel,
                radius=self.radius * wheel.radius,
                brake_gain=self.gain * wheel.brake_gain,
                relaxation_length=self.relaxation_length or wheel.relaxation_length,
            )
            for wheel in nominal.wheels
        )
        return replace(nominal, mass=self.mass * nominal.mass, wheels=wheels)

    @property
    def steady(self) -> "Perturbation":
        """The same on an even road."""
        return replace(self, load_variation=0.0)

    @property
    def actuator(self) -> ActuatorParameters:
        """Its hydraulics."""
        nominal = ActuatorParameters()
        return replace(nominal, delay=nominal.delay + self.delay, apply_rate=self.apply_rate * nominal.apply_rate)

    @property
    def sensors(self) -> SensorNoise:
        """Noise of its sensors; that of the speed sensor is not used."""
        return SensorNoise(
            self.noise**2 * CHAPTER_NOISE.wheel_speed_variance,
            CHAPTER_NOISE.speed_variance,
            self.noise**2 * CHAPTER_NOISE.torque_variance,
        )

    def gain_at(self, time: float) -> float:
        """Brake torque over that of the vehicle file, a time after the onset [s]."""
        return self.gain * max(1.0 - self.fading * max(time, 0.0), 0.0)

    def load_at(self, time: float, phases: Array) -> Array:
        """Wheel load over its mean at a time [s], shape (n,); `phases` [rad] has the shape (n, tones)."""
        if self.load_variation == 0.0:
            return np.ones(len(phases))
        frequencies = np.linspace(_LOWEST, _HIGHEST, _TONES)
        tones = np.sin(2.0 * np.pi * frequencies * time + phases).sum(axis=1)
        return np.asarray(1.0 + self.load_variation * np.sqrt(2.0 / _TONES) * tones)

    @staticmethod
    def phases(generator: np.random.Generator) -> Array:
        """Draw the phases of a road [rad], shape (tones,)."""
        return generator.uniform(0.0, 2.0 * np.pi, _TONES)


NONE = Perturbation()
_OF_ANY_CAR = (
    Perturbation("gain -20 %", gain=0.8),
    Perturbation("gain +20 %", gain=1.2),
    Perturbation("mass -20 %", mass=0.8),
    Perturbation("mass +20 %", mass=1.2),
    Perturbation("radius -2 %", radius=0.98),
    Perturbation("radius +2 %", radius=1.02),
    Perturbation("delay +10 ms", delay=0.01),
    Perturbation("delay +20 ms", delay=0.02),
    Perturbation("apply rate -30 %", apply_rate=0.7),
)
PERTURBATIONS: tuple[Perturbation, ...] = (
    Perturbation("noise x2", noise=2.0),
    *_OF_ANY_CAR,
    Perturbation("load varies 5 %", load_variation=0.05),
    Perturbation("load varies 10 %", load_variation=0.10),
    Perturbation("gain fades 10 %/s", fading=0.1),
)
"""Of the single corner."""
CAR_PERTURBATIONS: tuple[Perturbation, ...] = (
    *_OF_ANY_CAR,
    Perturbation("relaxation 0.2 m", relaxation_length=0.2),
    Perturbation("relaxation 0.5 m", relaxation_length=0.5),
    Perturbation("hill +6 %", hill=0.06),
    Perturbation("hill -6 %", hill=-0.06),
)
"""Of a car with four wheels; only that of `model: car` has the last four."""


CHANGES: Final = (
    "dry to snow",
    "snow to dry",
    "dry to wet",
    "wet to dry",
    "dry to cobblestone",
    "cobblestone to dry",
)
"""Names of the roads that change."""
_CHANGE_AT: Final = 30.0
"""[m] from the onset: the peak of the first surface has been passed, and the car is still fast."""
_TO: Final = " to "


def panic_road(name: str) -> Road:
    """Return the road of a name: that of a surface, or of two with ` to ` between. Distances are from the onset."""
    names = tuple(name.split(_TO))
    return Road(names, tuple(_CHANGE_AT * place for place in range(len(names))))


Flags = NDArray[np.bool_]
Commands = NDArray[np.int64]

DEMAND_RATIO = 1.5
"""Demand in units of the peak torque."""


@dataclass
class PanicPlant:
    """n corners on one road; at the start they roll freely at SPEED."""

    surface: str
    """Name of the road, which panic_road knows."""
    perturbation: Perturbation
    phases: Array
    """Phases of the wheel load [rad], shape (n, tones)."""
    nominal: CornerParameters = CORNER
    """The corner without the perturbation."""
    corner: SingleCorner = field(init=False)
    torque: Array = field(init=False)
    """That acts [N m], shape (n,)."""
    demand: float = field(init=False)
    """DEMAND_RATIO of the highest peak torque of the way [N m by the vehicle file]."""
    since: float = field(init=False, default=0.0)
    """Time since the onset of braking [s]."""

    def __post_init__(self) -> None:
        """Start at full speed."""
        count = len(self.phases)
        perturbation = self.perturbation
        self.parameters = perturbation.corner(self.nominal)
        self.way = panic_road(self.surface)
        self.corner = SingleCorner(self.parameters, np.full(count, SPEED))
        peaks = self.parameters.peak_torque(self.way.theta(np.array(self.way.distances)))
        self.demand = DEMAND_RATIO * float(np.max(peaks)) / perturbation.gain
        self.actuator = BrakeActuator(count, DT, perturbation.actuator)
        self.torque = np.zeros(count)
        self.time = 0.0
        self._onset = self.corner.distance

    @property
    def braked_way(self) -> Array:
        """Way since the onset of braking [m], shape (n,)."""
        return self.corner.distance - self._onset

    @property
    def theta(self) -> Array:
        """Burckhardt parameters under the wheels now, shape (n, 3)."""
        return self.way.theta(self.braked_way)

    @property
    def mu_max(self) -> Array:
        """Of the road under the wheels now [-], shape (n,)."""
        return np.asarray(burckhardt.peak(self.theta)[1])

    def road(self) -> Array:
        """Curves now, the wheel load in them, shape (n, 3)."""
        load = self.perturbation.load_at(self.time, self.phases)
        theta = self.theta.copy()
        theta[:, 0] *= load
        theta[:, 2] *= load
        return theta

    @property
    def best_deceleration(self) -> Array:
        """At mu_max [m/s^2], shape (n,)."""
        return self.mu_max * self.parameters.gravity

    @property
    def gain(self) -> float:
        """Brake torque over that of the vehicle file now [-]."""
        return self.perturbation.gain_at(self.since)

    @property
    def acceleration(self) -> Array:
        """Of the car [m/s^2], shape (n,)."""
        return self.corner.acceleration(self.road())

    def advance(self, demand: float, commands: Commands) -> None:
        """Advance by a sample under a demand [N m by the vehicle file], 0: not braked, and commands, shape (n,)."""
        if demand > 0.0:
            self.since += DT
        else:
            self._onset = self.corner.distance
        after = self.actuator.step(demand, commands) * self.gain
        self.corner.step(self.torque, after, self.road(), DT)
        self.torque = after
        self.time += DT


LOCK_TIME = 0.05
"""[s] A wheel is locked if it stands for so long."""
_LOCK_SLIP = 0.95


class LongestLock:
    """Follows n wheels."""

    def __init__(self, count: int, step: float = DT) -> None:
        """Start with none locked; `step` is the time between samples [s]."""
        self._step = step
        self.longest: Array = np.zeros(count)
        """[s], shape (n,)."""
        self._present: Array = np.zeros(count)

    def update(self, slip: Array, counts: Flags) -> None:
        """Take the slips of a sample and for which of them a lock counts, shape (n,)."""
        self._present = np.where(counts & (slip > _LOCK_SLIP), self._present + self._step, 0.0)
        self.longest = np.maximum(self.longest, self._present)


END_SPEED = 5.0
"""[m/s] first end of a stop."""
LOCK_ABOVE = 1.5
"""[m/s] below it the driver has the brake, and a lock does not count."""
LONGEST = 60.0
"""[s] after which a run is given up."""


@dataclass
class PanicStops:
    """Results of n stops, arrays of shape (n,)."""

    utilisation: Array
    """Mean of the deceleration over that at the present mu_max, from the onset to END_SPEED [-]."""
    utilisation_to_rest: Array
    """To standstill [-]."""
    distance: Array
    """From the onset to standstill [m]."""
    longest_lock: Array
    """[s] above LOCK_ABOVE."""
    changes: Array
    """Changes of the command in a second, above END_SPEED [1/s]."""
    stopped: Flags
    """Came to rest, and stayed."""


def brake_to_rest(plant: PanicPlant, brake: Callable[[Flags], Commands]) -> PanicStops:
    """Brake all corners of a plant to standstill.

    Args:
        plant: before the onset.
        brake: advances it by a sample; takes which corners still run, returns the commands, shape (n,).
    """
    corner = plant.corner
    count = corner.speed.size
    start, speed = corner.distance, corner.speed.copy()
    used_to_end, used = np.zeros(count), np.zeros(count)
    end_time, rest_time = np.full(count, np.nan), np.full(count, np.nan)
    changes = np.zeros(count)
    lock = LongestLock(count)
    before: Commands = np.ones(count, dtype=np.int64)
    running: Flags = np.ones(count, dtype=bool)
    while running.any() and plant.since < LONGEST:
        since, best = plant.since, plant.best_deceleration
        given = brake(running)
        changes += running & (given != before) & (speed > END_SPEED)
        before = given
        now = corner.speed
        crossed = (speed > END_SPEED) & (now <= END_SPEED)
        share = (speed - END_SPEED) / np.maximum(speed - now, 1e-12)
        lost = (speed - now) / best
        used_to_end += np.where(crossed, share * lost, lost * (now > END_SPEED))
        used += lost
        end_time = np.where(crossed, since + DT * share, end_time)
        lock.update(corner.slip, running & (now > LOCK_ABOVE))
        ended = running & (now <= 0.0)
        rest_time = np.where(ended, plant.since, rest_time)
        running = running & ~ended
        speed = now.copy()
    return PanicStops(
        utilisation=used_to_end / end_time,
        utilisation_to_rest=used / rest_time,
        distance=corner.distance - start,
        longest_lock=lock.longest,
        changes=changes / end_time,
        stopped=np.isfinite(rest_time) & (corner.speed <= 0.0),
    )
