"""Lateral slips of the wheels from the lateral forces of their axles, for each hypothesis about the curve.

With sigma = hypot(s_x, s_y) and the force along the slip, both wheels of an axle share one s_y:

    s_y = F / (k sum of mu(sigma) Fz / sigma)

s_y is solved on the near branch only, up to the peak. Close to it a force determines no slip: s_y is solved once more
for a force that is two deviations larger, and half the difference is its deviation.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_runtime.filters import first_order_gain
from friction_slope.slip_position.curve_shapes import LAMBDA, friction_ratio
from vehicle_models.lateral_forces import ACROSS, FORCE_STDDEV, AxleForces
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

UNMEASURED_FORCE_STDDEV: Final = 0.5
"""As FORCE_STDDEV, where yaw rate and lateral acceleration come from the wheel speeds [-]."""
FOLLOWED: Final = 0.03
"""Time in which the tyres follow [s]."""
WIDEST: Final = 2.0
"""Largest s_y of the larger force over lambda_max [-]."""
LEAST_FORCE: Final = 100.0
"""Least friction of an axle [N]."""


class LateralSlip:
    """Lateral slips of four wheels."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin straight ahead."""
        self._partner = np.array(AxleForces(vehicle).partner, dtype=np.int64)
        self._shape = (len(vehicle.wheels), LAMBDA.size)
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self.slip: Array = np.zeros(self._shape)
        """s_y [-], shape (n, H)."""
        self._larger: Array = np.zeros(self._shape)
        self.stddev: Array = np.zeros(self._shape)
        """Of s_y [-], shape (n, H)."""

    def solve(
        self, dt: float, slip: Array, mu: Array, loads: Array, weights: Array, forces: Array, measured: bool
    ) -> None:
        """Follow the forces over a time step.

        Args:
            dt: [s].
            slip: s_x of the tyres [-], shape (n,).
            mu: peak friction of each hypothesis [-], shape (n, H).
            loads: [N], shape (n,).
            weights: of the hypotheses, shape (n, H), sums of 1: the other wheel of the axle is as it probably is.
            forces: of the axle of each wheel [N], shape (n,).
            measured: whether yaw rate and lateral acceleration are measured.
        """
        force = np.abs(forces)[:, np.newaxis]
        stddev = FORCE_STDDEV if measured else UNMEASURED_FORCE_STDDEV
        gain = first_order_gain(dt, FOLLOWED)
        for s_y, asked, limit in (
            (self.slip, force, LAMBDA),
            (self._larger, (1.0 + 2.0 * stddev) * force, WIDEST * LAMBDA),
        ):
            sigma = np.maximum(np.hypot(slip[:, np.newaxis], s_y), 0.02 * LAMBDA)
            stiffness = mu * friction_ratio(sigma) * loads[:, np.newaxis] / sigma
            axle = stiffness + (weights * stiffness).sum(axis=1)[self._partner, np.newaxis]
            s_y += gain * (np.minimum(asked / np.maximum(ACROSS * axle, LEAST_FORCE), limit) - s_y)
        self.stddev = 0.5 * np.maximum(self._larger - self.slip, 0.0)
