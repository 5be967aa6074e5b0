"""Covariance of the wheel-based speed from radius errors, common and individual."""

from collections.abc import Sequence

from vehicle_models.vehicle import Vehicle, deviation_of


class RadiusDoubt:
    """Of the radii of one car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take what the vehicle file states."""
        count = len(vehicle.wheels)
        self.common = max(deviation_of(each.deviations, "radius", 0.0) / each.radius for each in vehicle.wheels)
        """Deviation that all radii have in common, as a share; 0 where the vehicle file states none."""
        self._covariance: Sequence[Sequence[float]] = [[0.0] * count] * count
        self.reset()

    def reset(self) -> None:
        """Forget which wheels gave the speed."""
        self.of_mean = 0.0
        """Variance of the mean radius of the wheels that gave it last, beside what is common, as a share squared."""
        self._wheels: list[int] = []

    def know(self, common: float, covariance: Sequence[Sequence[float]]) -> None:
        """Take how well the radii are known.

        Args:
            common: deviation that all of them have in common, as a share.
            covariance: of each beside that, as shares, shape (wheels, wheels).
        """
        self.common, self._covariance = common, covariance
        self._weigh()

    def use(self, wheels: list[int]) -> None:
        """Take which wheels give the speed."""
        if wheels != self._wheels:
            self._wheels = wheels
            self._weigh()

    def _weigh(self) -> None:
        wheels, covariance = self._wheels, self._covariance
        total = sum([covariance[one][other] for one in wheels for other in wheels])
        self.of_mean = total / len(wheels) ** 2 if wheels else 0.0
