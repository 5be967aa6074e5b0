"""A Kalman filter for each hypothesis about the curve and each wheel.

| state | | unit | |
|---|---|---|---|
| MU | mu_max | - | random walk |
| LOAD | friction by the unevenness of the load | - | first-order, as noisy as the road turns out to be |
| SPEED | error of the ground speed | m/s | random walk |
| DELAY | error of the pressure's delay | s | constant |
| INERTIA | relative error of inertia over brake gain | - | constant |
| DRAG | drag torque | N m | constant |
| TRANSFER | share of the springs in the load transfer, less a half | - | random walk |
| RELAXATION | error of the relaxation length | m | constant |

Measured is the mean friction of a block of samples, y = (J omega' + T)/(r Fz) = mu f s_x / sigma + ...
"""

from dataclasses import dataclass
from math import exp
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_slope.slip_position.common_road import own_weights
from friction_slope.slip_position.curve_shapes import INITIAL_SLOPE, LAMBDA
from vehicle_models.vehicle import Vehicle, absolute_deviation, relative_deviation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MU, LOAD, SPEED, DELAY, INERTIA, DRAG, TRANSFER, RELAXATION = STATES = range(8)

# Before the first block
PRIOR_MU: Final = 0.6, 0.5
"""Mean and deviation of mu_max of any road [-]."""
PRIOR_STIFFNESS: Final = 15.0, 12.0
"""Mean and deviation of the slip stiffness of a tyre over its load [-]: 3 to 40 on ice, snow and asphalt."""
PRIOR_LOAD: Final = 0.03
"""Relative deviation of a load on a common road [-]."""
PRIOR_TRANSFER: Final = 0.3
"""Deviation of the share of the springs [-]."""
LEAST_SPEED: Final = 0.02
"""Least deviation of the ground speed [m/s]."""

# Noise
MU_WALK: Final = 0.02
"""Change of mu_max with temperature and road [1/sqrt(s)]."""
SPEED_WALK: Final = 0.03
"""Change of the error of the ground speed beyond the change of its stated deviation [m/s/sqrt(s)]."""
TRANSFER_WALK: Final = 0.3
"""Of the share of the springs, whose pitch is not quite that of the model [1/sqrt(s)]."""
LOAD_MEMORY: Final = 0.03
"""Correlation time of the load's unevenness, wheel hop and body resonance between 1 and 14 Hz [s]."""
MODEL: Final = 0.01
"""Relative error of the curve's shape [-]."""
LEAST_FRICTION: Final = 0.3
"""Share of mu_max whose errors a wheel with little brake force has, too [-]."""
LEAST_MU: Final = 0.02
"""[-]"""

# What the filter makes of innovations
OUTLIER: Final = 3.0
"""Innovation beyond which it counts linearly [deviations]."""
INDEPENDENT: Final = 0.75
"""Share of a block's evidence that is its own: errors of shape and load last longer than a block [-]."""
EVIDENCE_MEMORY: Final = 2.0
"""Time in which evidence fades: what the model lacks lasts, and is no evidence again and again [s]."""
SCALE_GAIN: Final = 0.1
"""Share of a block in the estimate of the load's unevenness [-]."""
LOAD_RANGE: Final = 0.005, 0.3
"""Unevenness of the smoothest road, and of what is no road [-]."""
NEW_ROAD_LOG_DENSITY: Final = 0.19
"""Mean logarithm of the density of the friction of any road, with a deviation of 0.5 [-]."""
NEW_ROAD_EVIDENCE: Final = 6.0
"""Logarithm of the odds at which the road is another: it changes once in 400 blocks of a braking."""


_BY_STIFFNESS = np.array(PRIOR_STIFFNESS)[:, np.newaxis] * LAMBDA / INITIAL_SLOPE
_PRIOR_VARIANCE = 1.0 / (PRIOR_MU[1] ** -2 + _BY_STIFFNESS[1] ** -2)
_PRIOR_MEAN = _PRIOR_VARIANCE * (PRIOR_MU[0] * PRIOR_MU[1] ** -2 + _BY_STIFFNESS[0] * _BY_STIFFNESS[1] ** -2)


@dataclass(frozen=True)
class Block:
    """What a block of samples measured, arrays of shape (n,) or (n, H)."""

    duration: float
    """[s]"""
    used: Flags
    """Wheels that are braked and turn, (n,)."""
    friction: Array
    """y [-], (n,)."""
    variance: Array
    """White noise of y, (n,)."""
    spread: Array
    """Variance of y by the slip's age and by s_y, (n, H)."""
    ratio: Array
    """Mean of f s_x / sigma at the slips that the hypotheses correct [-], (n, H)."""
    by_speed: Array
    """Derivative of that by the ground speed [s/m], (n, H)."""
    by_relaxation: Array
    """Derivative of that by the relaxation length [1/m], (n, H)."""
    by_delay: Array
    """Derivatives of y by DELAY [1/s], INERTIA [-], DRAG [1/(N m)] and TRANSFER [-], (n,) each."""
    by_inertia: Array
    by_drag: Array
    by_transfer: Array


class Hypotheses:
    """All filters: arrays of shape (states, n, H) and (states, states, n, H)."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin without evidence; what is not known of the car is as its file states."""
        wheels = vehicle.wheels
        drag = absolute_deviation(vehicle.deviations, "engine_drag_torque")
        delay = absolute_deviation(vehicle.deviations, "brake_pressure_delay")
        share = [
            float(np.hypot(relative_deviation(wheel, "inertia"), relative_deviation(wheel, "brake_gain")))
            for wheel in wheels
        ]
        self._prior = np.zeros((len(STATES), len(wheels)))
        self._prior[DELAY], self._prior[INERTIA] = delay, share
        self._prior[DRAG] = [drag if wheel.driven else 0.0 for wheel in wheels]
        self._prior[TRANSFER] = PRIOR_TRANSFER
        self._prior[RELAXATION] = [
            wheel.relaxation_length * relative_deviation(wheel, "relaxation_length") for wheel in wheels
        ]
        shape = (len(wheels), LAMBDA.size)
        self.x = np.zeros((len(STATES), *shape))
        self.p = np.zeros((len(STATES), len(STATES), *shape))
        self.log_weights = np.zeros(shape)
        self.unevenness = np.full(len(wheels), PRIOR_LOAD)
        """Relative deviation of the load that explains the innovations [-], (n,)."""
        self._change = np.zeros(len(wheels))
        for wheel in range(len(wheels)):
            self.begin(wheel, LEAST_SPEED)

    def begin(self, wheel: int, speed_stddev: float) -> None:
        """Begin a braking of a wheel, whose ground speed has a deviation [m/s]."""
        self.unevenness[wheel] = PRIOR_LOAD
        self.change_road(wheel, speed_stddev)

    def change_road(self, wheel: int, speed_stddev: float) -> None:
        """Forget the road of a wheel; what varies without a curve that explains it is not forgotten."""
        self.x[:, wheel] = 0.0
        self.x[MU, wheel] = _PRIOR_MEAN
        self.p[:, :, wheel] = 0.0
        for state, stddev in enumerate(self._prior[:, wheel].tolist()):
            self.p[state, state, wheel] = stddev**2
        self.p[MU, MU, wheel] = _PRIOR_VARIANCE
        self.p[SPEED, SPEED, wheel] = max(speed_stddev, LEAST_SPEED) ** 2
        self.log_weights[wheel] = 0.0
        self._change[wheel] = 0.0

    def update(self, block: Block, speed_kept: Array, speed_added: Array) -> Flags:
        """Take a block; return the wheels whose road has changed, shape (n,), which the caller changes.

        `speed_kept` [-] is the share of the error of the ground speed that is left, and `speed_added` [m^2/s^2] the
        variance of what has come, shape (n,) each.
        """
        x, p, used = self.x, self.p, block.used[:, np.newaxis]
        own = own_weights(self.log_weights)
        level = np.maximum(np.abs(block.friction), LEAST_FRICTION * (own * x[MU]).sum(axis=1))
        self._predict(block.duration, level, speed_kept, speed_added)
        h = self._derivatives(block)
        # the ratio is that of the corrected slip
        predicted = (h * x).sum(axis=0) - h[SPEED] * x[SPEED] - h[RELAXATION] * x[RELAXATION]
        ph = np.einsum("ijnh,jnh->inh", p, h)
        variance = (h * ph).sum(axis=0) + block.spread + (block.variance + (MODEL * level) ** 2)[:, np.newaxis]
        innovation = block.friction[:, np.newaxis] - predicted
        size = np.abs(innovation) / np.sqrt(variance)
        linear = np.maximum(size / OUTLIER, 1.0)
        misfit = 0.5 * size * np.minimum(size, OUTLIER)
        density = np.exp(np.maximum(-misfit - 0.5 * np.log(variance), -60.0))
        likely = np.log((own * density).sum(axis=1) + 1e-30)
        self._change = np.where(block.used, np.maximum(self._change + NEW_ROAD_LOG_DENSITY - likely, 0.0), self._change)
        self.log_weights *= exp(-block.duration / EVIDENCE_MEMORY)
        self.log_weights += np.where(used, -INDEPENDENT * misfit, 0.0)
        gain = ph * np.where(used, 1.0 / (variance * linear), 0.0)
        x += gain * innovation
        p -= gain[:, np.newaxis] * ph
        np.maximum(x[MU], LEAST_MU, out=x[MU])
        growth = 0.5 * np.clip(SCALE_GAIN * ((own * size**2).sum(axis=1) - 1.0), -0.05, 0.3)
        self.unevenness = np.where(block.used, np.clip(self.unevenness * (1.0 + growth), *LOAD_RANGE), self.unevenness)
        return block.used & (self._change > NEW_ROAD_EVIDENCE)

    def _predict(self, duration: float, level: Array, speed_kept: Array, speed_added: Array) -> None:
        kept = exp(-duration / LOAD_MEMORY)
        self.x[LOAD] *= kept
        self.p[LOAD] *= kept
        self.p[:, LOAD] *= kept
        self.p[LOAD, LOAD] += ((1.0 - kept**2) * (self.unevenness * level) ** 2)[:, np.newaxis]
        self.p[MU, MU] += MU_WALK**2 * duration
        self.x[SPEED] *= speed_kept[:, np.newaxis]
        self.p[SPEED] *= speed_kept[:, np.newaxis]
        self.p[:, SPEED] *= speed_kept[:, np.newaxis]
        self.p[SPEED, SPEED] += (SPEED_WALK**2 * duration + speed_added)[:, np.newaxis]
        self.p[TRANSFER, TRANSFER] += TRANSFER_WALK**2 * duration

    def _derivatives(self, block: Block) -> Array:
        h = np.empty_like(self.x)
        h[MU] = block.ratio
        h[LOAD] = 1.0
        h[SPEED] = self.x[MU] * block.by_speed
        h[RELAXATION] = self.x[MU] * block.by_relaxation
        for state, of_wheels in (
            (DELAY, block.by_delay),
            (INERTIA, block.by_inertia),
            (DRAG, block.by_drag),
            (TRANSFER, block.by_transfer),
        ):
            h[state] = of_wheels[:, np.newaxis]
        return h
