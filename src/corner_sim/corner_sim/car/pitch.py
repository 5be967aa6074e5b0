"""Pitch of the body on its springs, and the load that moves between the axles with it."""

from math import pi


class Pitch:
    """p'' + 2 zeta w p' + w^2 p = w^2 a: p [m/s^2] is the acceleration whose steady pitch the body has now."""

    def __init__(self, frequency: float, damping: float, damper_share: float) -> None:
        """Begin level. `frequency` [Hz], `damping` ratio [-], share of the dampers' force that moves load [-]."""
        self._w = 2.0 * pi * frequency
        self._two_zeta = 2.0 * damping
        self._damper_time = damper_share * self._two_zeta / self._w
        self.angle = 0.0
        """p [m/s^2]."""
        self._rate = 0.0

    @property
    def load_acceleration(self) -> float:
        """Acceleration whose steady load transfer acts now [m/s^2]: springs, and the share of the dampers."""
        return self.angle + self._damper_time * self._rate

    def step(self, acceleration: float, dt: float) -> None:
        """Advance by dt [s], short against the period, at an acceleration of the body [m/s^2]."""
        self._rate += dt * self._w * (self._w * (acceleration - self.angle) - self._two_zeta * self._rate)
        self.angle += dt * self._rate
