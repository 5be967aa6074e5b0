"""One run of the plant behind its messages: messages in, messages out, no middleware and no clock."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from friction_msgs.msg import BrakeCommand, BrakeDemand

from corner_sim.car_plant import CAR, CarPlant, SensorErrors, in_order
from corner_sim.corner import JoinedCorners
from corner_sim.driver import DriverProfile
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, Plant, PlantSample, SlopeCrossings
from corner_sim.road import Road
from corner_sim.ros import messages
from corner_sim.ros.commands import CommandInbox, DemandInbox
from corner_sim.sensors import CHAPTER_NOISE, NO_NOISE, Sensors
from friction_runtime.processor import Output
from vehicle_models.vehicle import Vehicle

if TYPE_CHECKING:
    from corner_sim.smart_tyre.tyre_signal import TyreBlock, TyreSensors


class Simulation:
    """A run from the first sample on. `messages` returns the present sample, `advance` goes to the next."""

    def __init__(self, parameters: SimParameters, vehicle: Vehicle, start_stamp: int) -> None:
        """Build the run.

        Args:
            parameters: parameters of the run.
            vehicle: the car; model 'car' takes its wheels front left, front right, rear left, rear right.
            start_stamp: stamp of the first sample [ns], > 0.

        Raises:
            ValueError: parameters and vehicle do not fit each other; the message names them.
        """
        self._parameters = parameters
        self._start_stamp = start_stamp
        self._vehicle = vehicle = in_order(vehicle) if parameters.model == CAR else vehicle
        wheels = vehicle.wheel_names
        self._noise = CHAPTER_NOISE if parameters.noise == "chapter" else NO_NOISE
        self._plant: Plant | CarPlant
        self._sensors: Sensors | CarPlant
        road = Road(parameters.surfaces, parameters.surface_distances)
        p, speed = parameters, parameters.initial_speed
        if p.model == CAR:
            errors = SensorErrors(self._noise, p.acceleration_variance, p.acceleration_bias, p.seed)
            self._plant = self._sensors = car = CarPlant(vehicle, road, p.car, p.actuator, errors, speed)
            peak_torque = car.peak_torque
        else:
            model = JoinedCorners([vehicle.corner(name) for name in wheels], speed)
            self._plant = Plant(model, road, p.actuator, vehicle)
            self._sensors = Sensors(self._noise, p.acceleration_variance, p.acceleration_bias, vehicle, p.seed)
            peak_torque = model.peak_torque(road.theta(0.0))
        level = parameters.demand_level
        if parameters.demand_unit == "peak_ratio":
            level *= peak_torque
        self._driver = DriverProfile(
            level / vehicle.wheels[0].brake_gain,
            parameters.demand_start,
            parameters.demand_rise,
            parameters.demand_hold,
            parameters.demand_release,
        )
        self._demand = DemandInbox(wheels)
        self._commands = CommandInbox(wheels)
        self._crossings = SlopeCrossings(len(wheels))
        self._profile_in_force = parameters.demand_source == "profile"
        self._tyre_sensors = _tyre_sensors(parameters, vehicle)
        self._sample = self._plant.sample()
        self._blocks: list[TyreBlock] = []
        self._crossings.update(self._sample, self.stamp)

    @property
    def index(self) -> int:
        """Samples since the start."""
        return self._sample.index

    @property
    def time(self) -> float:
        """Message time since the start [s]."""
        return self.index * SAMPLE_TIME

    @property
    def stamp(self) -> int:
        """Stamp of the present sample [ns]."""
        return self._start_stamp + self.index * SAMPLE_TIME_NS

    @property
    def sample(self) -> PlantSample:
        """True state now."""
        return self._sample

    @property
    def speed(self) -> float:
        """Vehicle speed now [m/s]."""
        return self._sample.speed

    @property
    def distance(self) -> float:
        """Distance covered by the first wheel [m]."""
        return self._sample.distance

    @property
    def unanswered(self) -> list[str]:
        """Wheels whose last brake_command does not answer the present sample."""
        return self._commands.unanswered(self.stamp)

    @property
    def expired(self) -> list[str]:
        """Wheels whose newest brake_command holds no longer: it counts as NONE."""
        return self._commands.expired(self.stamp)

    @property
    def commands_lost(self) -> int:
        """Commands that their counters show to be missing."""
        return self._commands.lost

    @property
    def new_senders(self) -> int:
        """How often the counter of the commands began again."""
        return self._commands.new_senders

    @property
    def end(self) -> str | None:
        """Why the run has ended; None while it goes on."""
        p = self._parameters
        if self.speed <= p.end_speed:
            return f"speed {self.speed:.2f} m/s has reached end_speed {p.end_speed} m/s"
        if p.end_time > 0.0 and self.time >= p.end_time - 0.5 * SAMPLE_TIME:
            return f"end_time {p.end_time} s has passed"
        return None

    def messages(self, truth: bool = True) -> Sequence[Output]:
        """Measure the present sample and make its messages. Call it once per sample: each call draws noise.

        Args:
            truth: whether to make the messages of the truth; they are most of them.
        """
        p, wheels = self._parameters, self._vehicle.wheel_names
        outputs = messages.truth(self.stamp, wheels, self._sample, self._crossings) if truth else []
        if self._profile_in_force:
            outputs.append(("brake_demand", messages.brake_demand(self.stamp, self._driver.demand(self.time))))
        outputs += messages.sensors(
            self.stamp, self._vehicle, self._sensors.measure(self._sample), self._noise, p.acceleration_variance
        )
        if self._blocks:
            block_stamp = self.stamp - SAMPLE_TIME_NS
            outputs += messages.tyre_signals(block_stamp, wheels, self._blocks, p.inflation_pressure)
        return [output for output in outputs if p.vehicle_velocity or output[0] != "vehicle_velocity"]

    def take_command(self, wheel: str, message: BrakeCommand) -> str | None:
        """Take a brake_command of `wheel`; return why it is refused."""
        return self._commands.take(wheel, message, self.stamp)

    def take_demand(self, message: BrakeDemand) -> str | None:
        """Take a brake_demand; return why it is refused."""
        return self._demand.take(message)

    def advance(self) -> None:
        """Go to the next sample under the commands and the demand in force."""
        demand = self._driver.demand(self.time) if self._profile_in_force else self._demand.pressure
        self._plant.advance(demand, self._commands.commands(self.stamp))
        before, self._sample = self._sample, self._plant.sample()
        if self._tyre_sensors is not None:
            self._blocks = self._tyre_sensors.between(before, self._sample)
        self._crossings.update(self._sample, self.stamp)


def _tyre_sensors(p: SimParameters, vehicle: Vehicle) -> "TyreSensors | None":
    if not p.tyre_signals:
        return None
    # here, because scipy.signal behind it takes a second to load
    from corner_sim.smart_tyre.tyre_signal import TyreSensors

    return TyreSensors(vehicle, p.noise != "none", p.inflation_pressure, p.seed)
