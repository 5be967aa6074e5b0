"""Controllers of an emergency stop: the shipped graph with abs_supervisor, and a threshold ABS as the baseline."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from math import isfinite
from typing import Any

import numpy as np
from friction_msgs.msg import BrakeCommand, BrakeDemand, WheelSlip

from abs_supervisor.parameters import SHIPPED as SHIPPED_SUPERVISOR
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.ros.processor import WheelProcessor as SupervisorProcessor
from benchmarks.abs.panic_stop import NONE, Commands, Flags, PanicPlant, PanicStops, Perturbation, brake_to_rest
from benchmarks.protocol import ACCELERATION_OFFSET, ACCELERATION_STDDEV, CAR, DT, STEP
from benchmarks.stated_deviations import stating
from corner_sim.ros import messages
from corner_sim.sensors import Measurement, SensorNoise
from friction_curve_id.parameters import SHIPPED as SHIPPED_CURVE
from friction_curve_id.ros.processor import build as curve_processors
from friction_runtime.command_checksum import sealed
from friction_runtime.processor import Health, Output, Processor, ProcessorGraph
from friction_slope.parameters import SHIPPED as SHIPPED_SLOPE
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor as SlopeProcessor
from vehicle_models.brake_actuator import Command
from vehicle_models.vehicle import FRONT, Vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.ros.processor import CarProcessor

Parameters = tuple[FrictionSlopeParameters, SupervisorParameters]


def shipped() -> Parameters:
    """Return the shipped parameters of the supervisor's loop, in which it commands."""
    supervisor = SHIPPED_SUPERVISOR["abs_supervisor"].parameters
    return SHIPPED_SLOPE["friction_slope"].parameters, replace(supervisor, shadow=False)


def one_wheel(vehicle: Vehicle) -> Vehicle:
    """Return the first wheel of a car as a car of its own, with the mass that rests on it."""
    first = replace(vehicle.wheels[0], axle=FRONT)
    return replace(vehicle, wheels=(first,), mass=vehicle.corner(first.name).mass, front_load_share=1.0)


def processors(alone: Vehicle, parameters: Parameters) -> list[Processor]:
    """Make those of the graph for a car of one wheel; the supervisor is the last."""
    slope, supervisor = parameters
    wheel = alone.wheels[0].name
    return [
        CarProcessor(alone, SHIPPED_SLIP["wheel_slip"].parameters),
        SlopeProcessor(wheel, alone, slope, estimates=False),
        *curve_processors(SHIPPED_CURVE["friction_curve_id"].parameters, alone),
        SupervisorProcessor(wheel, alone, supervisor),
    ]


class Controller:
    """The processors of one run, from its sensors to the command. The car has one wheel."""

    def __init__(
        self,
        vehicle: Vehicle,
        noise: SensorNoise,
        make: Callable[[Vehicle], Sequence[Processor]],
        *,
        speed_sensor: bool = True,
    ) -> None:
        """Build them for the first wheel of a car, whose sensors state the variances of `noise`.

        Args:
            vehicle: its first wheel brakes.
            noise: variances of the sensors.
            make: makes the processors of a car of one wheel.
            speed_sensor: whether they have a speed sensor.
        """
        self._vehicle, self._noise, self._speed_sensor = one_wheel(vehicle), noise, speed_sensor
        self.processors = make(self._vehicle)
        self._graph = ProcessorGraph(self.processors)

    def command(self, stamp: int, measured: Measurement, demand: float) -> int:
        """Pass the sensors' readings at a stamp [ns] and the demand [Pa] through; return the command for them."""
        found: int | None = None
        sensors = messages.sensors(stamp, self._vehicle, measured, self._noise, 0.0)
        for topic, message in (("brake_demand", messages.brake_demand(stamp, demand)), *sensors):
            if topic == "vehicle_velocity" and not self._speed_sensor:
                continue
            for _, answer in self._graph.feed(topic, message):
                if isinstance(answer, BrakeCommand):
                    found = int(answer.command)
        if found is None:
            raise RuntimeError(f"no brake_command at stamp {stamp} ns")
        return found


@dataclass(frozen=True)
class InertialSensing:
    """Motion sensors that the graph has; the defaults are the chapter's."""

    speed_sensor: bool = True
    offset: float = 0.0
    """Of the accelerometer [m/s^2], on top of that of the vehicle file."""
    stddev: float = 0.0
    """Of its noise [m/s^2]."""


class BrakedCorners:
    """The first wheel of a car, once for each seed of the sensor noise; at the start they roll freely."""

    def __init__(
        self,
        surface: str,
        seeds: range,
        make: Callable[[Vehicle], Sequence[Processor]],
        sensing: InertialSensing = InertialSensing(),
        perturbation: Perturbation = NONE,
        vehicle: Vehicle = CAR,
    ) -> None:
        """Start at SPEED.

        Args:
            surface: its name.
            seeds: of the sensor noise and of the road's unevenness.
            make: makes the processors of a car of one wheel, which command its brake.
            sensing: motion sensors that the graph has.
            perturbation: differences between the car and the nominal vehicle of the graph.
            vehicle: its first wheel brakes.
        """
        wheel = vehicle.wheels[0]
        phases = np.array([Perturbation.phases(np.random.default_rng((seed, 3))) for seed in seeds])
        self.plant = PanicPlant(surface, perturbation, phases, vehicle.corner(wheel.name))
        noise = perturbation.sensors
        self.controllers = [Controller(vehicle, noise, make, speed_sensor=sensing.speed_sensor) for _ in seeds]
        self._noise, self._sensing = noise, sensing
        self._gain, self._accelerometer = wheel.brake_gain, vehicle.accelerometer
        # Streams of their own: the wheel's noise does not depend on how the car's motion is measured.
        self._generators = [np.random.default_rng(seed) for seed in seeds]
        self._of_speed = [np.random.default_rng((seed, 1)) for seed in seeds]
        self._of_accelerometer = [np.random.default_rng((seed, 2)) for seed in seeds]
        self._samples = 0

    def commands(self, demand: float, running: Flags) -> Commands:
        """Read the sensors and return the commands, shape (n,), under a demand [N m by the vehicle file].

        Where `running` is false, shape (n,), no sensor is read and the command is 0.
        """
        self._samples += 1
        plant, noise, sensing = self.plant, self._noise, self._sensing
        commands = np.zeros(len(self.controllers), dtype=np.int64)
        acceleration = plant.acceleration
        for i in np.flatnonzero(running).tolist():
            draw = self._generators[i].standard_normal(2)
            torque = plant.torque[i] / plant.gain + np.sqrt(noise.torque_variance) * draw[1]
            speed_error = np.sqrt(noise.speed_variance) * self._of_speed[i].standard_normal()
            error = sensing.offset + sensing.stddev * self._of_accelerometer[i].standard_normal()
            measured = Measurement(
                wheel_speed=np.array([plant.corner.wheel_speed[i] + np.sqrt(noise.wheel_speed_variance) * draw[0]]),
                brake_pressure=np.array([torque / self._gain]),
                speed=float(plant.corner.speed[i] + speed_error),
                acceleration=self._accelerometer.reading(float(acceleration[i]) + error),
            )
            commands[i] = self.controllers[i].command(self._samples * STEP, measured, demand / self._gain)
        return commands

    def roll(self, samples: int) -> None:
        """Advance without brake."""
        running = np.ones(len(self.controllers), dtype=bool)
        for _ in range(samples):
            self.plant.advance(0.0, self.commands(0.0, running))

    def brake(self, running: Flags) -> Commands:
        """Advance by a sample under the full demand; return the commands, as above."""
        given = self.commands(self.plant.demand, running)
        self.plant.advance(self.plant.demand, given)
        return given


THRESHOLDS = "threshold"
"""Name of this law."""
_WINDOW = 5
"""Samples over which the acceleration is taken."""


@dataclass(frozen=True)
class Thresholds:
    """Of the wheel's circumference and of its slip."""

    deceleration: float = 54.0
    """[m/s^2] from which on the pressure is not raised."""
    slip: float = 0.29
    """With which it is lowered."""
    comes_back: float = -2.5
    """[m/s^2] of acceleration with which a release ends."""
    accelerates: float = 58.0
    """[m/s^2] of acceleration with which the pressure is held while a wheel comes back."""
    step: int = 4
    """Samples from step to step when the pressure is applied again."""
    least_speed: float = 1.5
    """[m/s] below which the driver has the brake."""


class _Phase(Enum):
    FIRST = 0
    RELEASE = 1
    RETURN = 2
    STEPS = 3


class ThresholdAbs:
    """Commands one wheel; a processor of the graph that fires on <wheel>/slip."""

    def __init__(self, wheel: str, radius: float, thresholds: Thresholds = Thresholds()) -> None:
        """Choose a wheel of an effective radius [m]."""
        self._wheel, self._radius, self._t = wheel, radius, thresholds
        self.sensors: Mapping[str, type] = {"brake_demand": BrakeDemand}
        self.estimates: Mapping[str, type] = {f"{wheel}/slip": WheelSlip}
        self.outputs: Mapping[str, type] = {f"{wheel}/brake_command": BrakeCommand}
        self.optional: Sequence[str] = ()
        self.reset()

    def reset(self) -> None:
        """Start again."""
        self._braking = False
        self._speeds: deque[float] = deque(maxlen=_WINDOW)
        self._phase, self._count = _Phase.FIRST, 0

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Do nothing: it runs offline."""
        return []

    def health(self) -> Health:
        """Return the phase."""
        return Health(self._wheel, message=self._phase.name)

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take a message; return the command for a slip."""
        if topic == "brake_demand":
            self._braking = message.pressure > 0.0
            return []
        command = BrakeCommand(header=message.header, wheel=self._wheel, valid_for=1.0)
        command.command = int(self._command(message))
        return [(f"{self._wheel}/brake_command", sealed(command))]

    def _command(self, message: WheelSlip) -> Command:
        self._speeds.append(message.wheel_speed)
        if not self._braking or not message.vehicle_speed > self._t.least_speed:
            self._phase = _Phase.FIRST
            return Command.NONE
        t, speeds = self._t, self._speeds
        acceleration = self._radius * (speeds[-1] - speeds[0]) / (DT * max(len(speeds) - 1, 1))
        slips = isfinite(message.slip) and message.slip > t.slip
        dives = acceleration < -t.deceleration
        if self._phase in (_Phase.FIRST, _Phase.STEPS):
            if slips and acceleration < t.comes_back:
                self._phase = _Phase.RELEASE
        elif self._phase is _Phase.RELEASE and acceleration > t.comes_back:
            self._phase = _Phase.RETURN
        elif self._phase is _Phase.RETURN and not slips and acceleration < t.accelerates:
            self._phase, self._count = _Phase.STEPS, 0
        elif self._phase is _Phase.RETURN and slips and acceleration < t.comes_back:
            self._phase = _Phase.RELEASE
        if self._phase is _Phase.RELEASE:
            return Command.DECREASE
        if self._phase is _Phase.RETURN or dives:
            return Command.HOLD
        if self._phase is _Phase.STEPS:
            self._count += 1
            return Command.INCREASE if self._count % t.step == 0 else Command.HOLD
        return Command.INCREASE


ROLLING = round(3.0 / DT)
"""Samples of free rolling before the brake, in which wheel_slip learns the offset of the accelerometer."""


def law_stops(surface: str, seeds: range, law: str, perturbation: Perturbation) -> PanicStops:
    """Brake once for each seed, side by side.

    Args:
        surface: its name.
        seeds: of the sensor noise and the road's roughness.
        law: of abs_supervisor, or THRESHOLDS.
        perturbation: differences between the car and the nominal vehicle of the graph.
    """
    sensing = InertialSensing(speed_sensor=False, offset=ACCELERATION_OFFSET, stddev=ACCELERATION_STDDEV)
    # a file of a car that differs from it does not claim to be exact
    vehicle = _uncertain(CAR) if perturbation.of_vehicle else CAR
    braked = BrakedCorners(surface, seeds, partial(_processors, law), sensing, perturbation, vehicle)
    braked.roll(ROLLING)
    return brake_to_rest(braked.plant, braked.brake)


def _uncertain(vehicle: Vehicle) -> Vehicle:
    """Return a vehicle whose file states what is usually not known of a car: load, pads, tyres, and a sample."""
    of_car = {"mass": 0.1 * vehicle.mass, "brake_pressure_delay": 0.01}
    return stating(vehicle, of_car, {"brake_gain": 0.1, "radius": 0.01})


def _processors(law: str, alone: Vehicle) -> list[Processor]:
    if law == THRESHOLDS:
        (wheel,) = alone.wheels
        return [CarProcessor(alone, SHIPPED_SLIP["wheel_slip"].parameters), ThresholdAbs(wheel.name, wheel.radius)]
    slope, supervisor = shipped()
    return processors(alone, (slope, replace(supervisor, real_time=False, law=law)))
