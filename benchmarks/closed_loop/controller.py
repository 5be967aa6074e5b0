"""The shipped estimators and abs_supervisor in the loop, connected as the nodes of the graph are."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from friction_msgs.msg import BrakeCommand

from abs_supervisor.parameters import SHIPPED as SHIPPED_SUPERVISOR
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.ros.processor import WheelProcessor as SupervisorProcessor
from corner_sim import messages
from corner_sim.sensors import Measurement
from friction_curve_id.parameters import SHIPPED as SHIPPED_CURVE
from friction_curve_id.ros.processor import build as curve_processors
from friction_runtime.processor import Processor
from friction_runtime.processor_graph import ProcessorGraph
from friction_slope.parameters import SHIPPED as SHIPPED_SLOPE
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor as SlopeProcessor
from vehicle_models.sensor_noise import SensorNoise
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
            speed_sensor: whether they are told the speed of the car.
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
