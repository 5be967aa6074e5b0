"""The shipped friction_slope (no_slip) and abs_supervisor in the loop.

`slip_at_crossing` is off: it does not enter the indicator, and without it the loop needs no wheel_slip.
"""

from dataclasses import replace

import numpy as np
from friction_msgs.msg import BrakeCommand

from abs_supervisor.parameters import SHIPPED as SHIPPED_SUPERVISOR
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.processor import WheelProcessor as SupervisorProcessor
from corner_sim import messages
from corner_sim.sensors import Measurement
from friction_parameters.values import changed
from friction_runtime.stamps import from_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.processor import WheelProcessor as SlopeProcessor
from vehicle_models.vehicle import Vehicle

Parameters = tuple[FrictionSlopeParameters, SupervisorParameters]


def shipped() -> Parameters:
    """Return the shipped parameters of the supervisor's loop, in which it commands."""
    slope = changed(SHIPPED["friction_slope"].parameters, {"no_slip.slip_at_crossing": False})
    return slope, replace(SHIPPED_SUPERVISOR["abs_supervisor"].parameters, shadow=False)


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
