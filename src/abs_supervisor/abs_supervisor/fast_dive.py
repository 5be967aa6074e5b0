"""Lock time margin: time from the peak to a lock against the release time of the brake.

Beyond the peak a wheel lacks the torque D that a sliding tyre gives less than a rolling one. It stands still after
2 J omega / D, and the brake needs D / rate to let it turn again: on dry at 7 m/s, with 1.8 kN m, 75 ms and 130 ms.
"""

from typing import Final

from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.vehicle import CornerParameters

_LOST: Final = 0.35
"""Share of the torque at the peak that a sliding tyre does not give: 0.30 to 0.37 on the roads of Table 8.1."""


class FastDive:
    """Compares the dive of one wheel with its brake."""

    def __init__(self, corner: CornerParameters, actuator: ActuatorParameters) -> None:
        """Choose a wheel and its hydraulics."""
        self._spin = 2.0 * corner.inertia / corner.radius
        self._rate, self._delay = actuator.release_rate, actuator.delay

    def outruns_brake(self, car_speed: float, torque: float) -> bool:
        """Return whether no release comes in time.

        Args:
            car_speed: [m/s], NaN where unknown.
            torque: of the brake at the peak [N m], NaN where unknown.
        """
        lost = _LOST * torque
        return self._spin * car_speed < lost * (self._delay + lost / self._rate)
