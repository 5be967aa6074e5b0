"""Time spent beyond the peak (95 % confidence), required for validity."""

from math import exp, inf, sqrt

import numpy as np

from friction_curve_id.car.car_model import Nodes
from friction_curve_id.car.evidence import Peak
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.node_signals import TURNING
from friction_curve_id.car.unknowns import Unknown

_PASSED = 1.05
"""Slip over lambda_max that counts as beyond the peak for validity."""
_SURE = 1.645
"""Deviations of one-sided 95 %."""
_TIME = 0.1
"""Time beyond the peak, summed over wheels, that makes a peak seen [s]."""
_LEAST_AGE = 0.1
"""Time since the slip first was beyond the peak before it is valid [s]."""


class Passing:
    """How the peak of a road was passed."""

    def __init__(self) -> None:
        """Begin before the peak."""
        self.time_beyond = 0.0
        """Time for which slips were surely beyond the peak, summed over the wheels [s]."""
        self._since = inf

    def update(self, fit: CurveFit, peak: Peak, nodes: Nodes) -> None:
        """Take the nodes of the window with the fit that was moved last.

        A node near one at which a wheel may stand says nothing of a torque, but its own slip is known.
        """
        moved = fit.moved
        limit = _PASSED * exp(peak.log_lambda_max)
        speed_variance = fit.covariance[Unknown.START_SPEED, Unknown.START_SPEED]
        stddev = np.hypot(limit * peak.log_lambda_stddev, sqrt(speed_variance) / moved.speed)
        turning = nodes.turning | (moved.slip < 1.0 - TURNING)
        beyond = turning & (moved.relaxed > limit + _SURE * stddev)
        if not beyond.any():
            self._since = inf
        elif self._since == inf:
            self._since = float(nodes.time[int(np.argmax(beyond.any(axis=0)))])
        self.time_beyond = float((beyond * nodes.interval).sum())

    @property
    def begun(self) -> bool:
        """Whether a wheel has been beyond the peak for any time."""
        return self.time_beyond > 0.0

    @property
    def seen(self) -> bool:
        """Whether the peak has been seen."""
        return self.time_beyond >= _TIME

    def long_ago(self, time: float) -> bool:
        """Whether it was first passed long enough before `time`, on the clock of the nodes [s]."""
        return time - self._since >= _LEAST_AGE
