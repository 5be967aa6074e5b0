"""A brake: torque behind the pressure of its line, with a gain that fades as the pads take up work."""

from math import exp


class Brake:
    """One brake."""

    def __init__(self, gain: float, lag: float, fading: float, fading_energy: float, dt: float) -> None:
        """Begin cold and without pressure. Arguments as in CarParameters; `dt` [s] is the time step."""
        self._gain = gain
        self._follow = 1.0 - exp(-dt / lag) if lag > 0.0 else 1.0
        self._fading, self._fading_energy = fading, fading_energy
        self._dt = dt
        self._pressure = 0.0
        self._work = 0.0

    @property
    def gain(self) -> float:
        """Torque over pressure now [N m/Pa]."""
        return self._gain * (1.0 - self._fading * min(self._work / self._fading_energy, 1.0))

    def torque(self, pressure: float, wheel_speed: float) -> float:
        """Torque [N m] over the next step, by pressure [Pa] at the wheel speed [rad/s]."""
        self._pressure += self._follow * (pressure - self._pressure)
        torque = self.gain * self._pressure
        self._work += torque * wheel_speed * self._dt
        return torque
