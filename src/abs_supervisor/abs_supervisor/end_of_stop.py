"""Low-speed hold: no approach to the peak where a lock is faster than the brake's release.

The machine of section 8.2.2 knows only rising and falling pressure, so that each of its cycles passes the peak. A wheel
that has been released once is therefore kept before it: the pressure does not rise beyond the slip of a release.
"""

from abs_supervisor.fast_dive import FastDive
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import CornerParameters


class EndOfStop:
    """Follows the releases of one wheel, and holds what the machine would raise."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters) -> None:
        """Choose a wheel and its hydraulics."""
        self._dive = FastDive(corner, actuator)
        self._released = False

    def reset(self) -> None:
        """Forget the release."""
        self._released = False

    def ask(self, machine: Command, grips: bool, car_speed: float, torque: float) -> Command:
        """Return what is asked for: HOLD in place of INCREASE at the end of a stop with releases.

        Args:
            machine: what the machine asks for.
            grips: whether the wheel has the slip of a release already.
            car_speed: [m/s], NaN where unknown.
            torque: of the brake [N m], NaN where unknown.
        """
        if machine is not Command.INCREASE or not (self._released and grips):
            return machine
        return Command.HOLD if self._dive.outruns_brake(car_speed, torque) else machine

    def commanded(self, command: Command) -> None:
        """Note the command that was given."""
        if command is Command.NONE:
            self._released = False
        elif command is Command.DECREASE:
            self._released = True
