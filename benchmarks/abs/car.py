"""Emergency stops of a car with four wheels on the shipped graph, with nominal or perturbed parameters."""

from dataclasses import dataclass, fields, replace

import numpy as np
from friction_msgs.msg import BrakeCommand

from abs_supervisor.axle import NO_AXLE
from benchmarks.abs.controllers import ROLLING
from benchmarks.abs.panic_stop import (
    DEMAND_RATIO,
    END_SPEED,
    LOCK_ABOVE,
    LONGEST,
    NONE,
    Array,
    LongestLock,
    PanicStops,
    Perturbation,
    panic_road,
)
from benchmarks.closed_loop import loop_parameters, take_sample
from benchmarks.protocol import ACCELERATION_OFFSET, ACCELERATION_STDDEV, DT, SPEED
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import peak_pressures
from corner_sim.car.tyres import TYRES
from corner_sim.car_plant import CAR, SAME, CarModelParameters, SensorErrors, as_it_is, in_order
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME
from corner_sim.road import Road
from corner_sim.ros.simulation import Simulation
from corner_sim.sensors import NO_NOISE
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, make_processors
from friction_runtime.processor import Processor, ProcessorGraph, silent
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

SHIPPED_CAR = "compact_car"
_ROLLED = SPEED * ROLLING * DT
"""[m] before the onset; less what the drag takes."""
_HILL = _ROLLED + 15.0
"""[m] Where a hill begins."""
_START = 10_000 * NANOSECONDS
"""Stamp of the first sample."""


@dataclass(frozen=True)
class CarSetup:
    """A car on one road, without speed sensor, braked with the full demand after ROLLING samples."""

    surface: str
    """Name of a road, which panic_road knows."""
    perturbation: Perturbation = NONE
    right_surface: str = SAME
    """Of the right wheels."""
    tyre: str = "burckhardt"
    """Family of its tyres."""
    select_low: str = NO_AXLE
    """Axle whose wheels get the same pressure."""
    yaw_moment_rate: float = 0.0
    """Fastest growth of the moment of the front brakes [N m/s]; 0: no limit."""

    @property
    def nominal(self) -> Vehicle:
        """The car as the graph knows it, wheels in the order of the plant."""
        car = replace(load_vehicle(SHIPPED_CAR), front_yaw_moment_rate=self.yaw_moment_rate)
        return in_order(car)

    @property
    def vehicle(self) -> Vehicle:
        """The car that brakes."""
        return self.perturbation.vehicle(self.nominal)

    @property
    def road(self) -> Road:
        """Surfaces from where the run starts on; one that changes does so soon after the onset of braking."""
        way = panic_road(self.surface)
        return Road(way.names, [distance + _ROLLED * (distance > 0.0) for distance in way.distances])

    @property
    def demand(self) -> float:
        """DEMAND_RATIO times the pressure [Pa] at which the wheel with the weakest brake for its load has its peak.

        On the surface of the way where that is highest.
        """
        roads = [car_parameters(self.vehicle, name) for name in self.road.names]
        return DEMAND_RATIO * max(max(peak_pressures(each)) for each in roads)

    @property
    def parameters(self) -> SimParameters:
        """Those of the plant."""
        return SimParameters(
            model=CAR,
            initial_speed=SPEED,
            surfaces=self.road.names,
            surface_distances=self.road.distances,
            demand_unit="torque",
            demand_level=self.demand * self.vehicle.wheels[0].brake_gain,
            demand_start=ROLLING * DT,
            acceleration_variance=ACCELERATION_STDDEV**2,
            acceleration_bias=ACCELERATION_OFFSET,
            vehicle_velocity=False,
            actuator=self.perturbation.actuator,
            car=CarModelParameters(
                tyre=self.tyre,
                load_variation=self.perturbation.load_variation,
                right_surface=self.right_surface,
                hill=self.perturbation.hill,
                hill_distance=_HILL,
            ),
        )

    def simulation(self, seed: int) -> Simulation:
        """Return the plant at its first sample."""
        return Simulation(replace(self.parameters, seed=seed), self.vehicle, _START)


def car_parameters(vehicle: Vehicle, road: str) -> CarParameters:
    """The car of a vehicle file on a road, undisturbed."""
    return as_it_is(vehicle, TYRES["burckhardt"][road], CarModelParameters(), SensorErrors(NO_NOISE, 0.0, 0.0, 0))


def car_stops(setup: CarSetup, seeds: range, law: str) -> PanicStops:
    """Brake once for each seed, of the sensor noise and of the road, under a law of abs_supervisor.

    Utilisation is that of the tyres: their braking forces over those of their peaks. The longest lock is that of any
    wheel, the changes of the command are a mean of the wheels.
    """
    found = [car_stop(setup, seed, law).stops for seed in seeds]
    columns = {each.name: np.concatenate([getattr(stop, each.name) for stop in found]) for each in fields(PanicStops)}
    return PanicStops(**columns)


@dataclass(frozen=True)
class CarStop:
    """One stop."""

    stops: PanicStops
    """n = 1."""
    yaw_moment: Array
    """About the vertical, from the onset on [N m], shape (k,)."""
    slip_error: Array
    """Of the slips in valid messages of `friction_curve` above END_SPEED [-], shape (m,)."""
    slip_stddev: Array
    """What they say of it [-], shape (m,)."""


def car_stop(setup: CarSetup, seed: int, law: str) -> CarStop:
    """Brake once."""
    wheels = setup.nominal.wheel_names
    graph = ProcessorGraph(_processors(law, setup))
    simulation = setup.simulation(seed)
    lock = LongestLock(len(wheels))
    slip, force = np.zeros(len(wheels)), np.zeros(len(wheels))
    commands = np.ones(len(wheels), dtype=np.int64)
    before = commands.copy()
    used: list[float] = []
    moments: list[float] = []
    curves = {f"{wheel}/friction_curve" for wheel in wheels}
    slips: list[tuple[float, float]] = []
    changes, fast, start = 0, 0, 0.0
    while simulation.end is None and simulation.time < ROLLING * SAMPLE_TIME + LONGEST:
        braking = simulation.index >= ROLLING
        for topic, message in take_sample(simulation, graph):
            if topic.startswith("truth/") and topic.endswith("/slip"):
                slip[wheels.index(message.wheel)] = message.slip
            elif topic.startswith("truth/") and topic.endswith("/tyre_force"):
                force[wheels.index(message.wheel)] = -message.fx
            elif isinstance(message, BrakeCommand):
                commands[wheels.index(message.wheel)] = message.command
            elif simulation.speed > END_SPEED and topic in curves and message.validity.valid:
                slips.append((message.slip - slip[wheels.index(message.wheel)], message.slip_stddev))
        if simulation.index == ROLLING:
            start = simulation.distance
        if braking:
            sample = simulation.sample
            used.append(float(force.sum() / (sample.vertical_load @ sample.peak[:, 1])))
            moments.append(sample.yaw_moment)
            lock.update(np.nan_to_num(slip), np.full(len(wheels), simulation.speed > LOCK_ABOVE))
            if simulation.speed > END_SPEED:
                fast += 1
                changes += int((commands != before).sum())
        before = commands.copy()
        simulation.advance()
    found = PanicStops(
        utilisation=np.array([np.mean(used[:fast])]),
        utilisation_to_rest=np.array([np.mean(used)]),
        distance=np.array([simulation.distance - start]),
        longest_lock=lock.longest.max(keepdims=True),
        changes=np.array([changes / len(wheels) / (fast * SAMPLE_TIME)]),
        stopped=np.array([simulation.end is not None]),
    )
    error, stddev = np.array(slips).reshape(-1, 2).T
    return CarStop(found, np.array(moments), error, stddev)


def _processors(law: str, setup: CarSetup) -> list[Processor]:
    nominal = setup.nominal
    parameters = loop_parameters(WHEEL_ESTIMATORS, law)
    parameters["abs_supervisor"] = replace(parameters["abs_supervisor"], select_low=setup.select_low)
    return make_processors(parameters, nominal, silent)
