"""Largest slips on this road: a peak below them has been passed (95 % confidence), and stays so."""

from math import exp, inf, sqrt

import numpy as np

from friction_curve_id.car.evidence import Peak
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.node_signals import TURNING, Nodes
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
    """How the peak of a road was passed.

    The slips stay when their samples have left the window, and are compared with what lambda_max is now: where its
    deviation has grown so far that they may have been before the peak, it is not seen any more.
    """

    def __init__(self) -> None:
        """Begin before the peak."""
        self._largest = self._lasting = 0.0
        """Largest slip, and the largest that was exceeded for _TIME, both less the error of the speed [-]."""
        self._in_window = 0.0
        self._limit = inf
        self._since = inf

    def update(self, fit: CurveFit, peak: Peak, nodes: Nodes) -> None:
        """Take the nodes of the window with the fit that was moved last.

        A node near one at which a wheel may stand says nothing of a torque, but its own slip is known.
        """
        moved = fit.moved
        speed_variance = fit.covariance[Unknown.START_SPEED, Unknown.START_SPEED]
        turning = nodes.turning | (moved.slip < 1.0 - TURNING)
        error = np.hypot(sqrt(speed_variance) / moved.speed, fit.tyres.across_stddev)
        reached = np.where(turning, fit.tyres.size - _SURE * error, 0.0)
        order = np.argsort(reached, axis=None)[::-1]
        slips, times = reached.ravel()[order], np.broadcast_to(nodes.interval, reached.shape).ravel()[order]
        lasting = int(np.searchsorted(times.cumsum(), _TIME))
        self._largest = max(self._largest, float(slips[0]))
        self._in_window = float(slips[lasting]) if lasting < len(slips) else 0.0
        self._lasting = max(self._lasting, self._in_window)
        self._limit = exp(peak.log_lambda_max) * (_PASSED + _SURE * peak.log_lambda_stddev)
        if not self.begun:
            self._since = inf
        elif self._since == inf:
            beyond = (reached > self._limit).any(axis=0)
            self._since = float(nodes.time[int(np.argmax(beyond))])

    @property
    def begun(self) -> bool:
        """Whether a wheel has been beyond the peak for any time."""
        return self._largest > self._limit

    @property
    def seen(self) -> bool:
        """Whether the peak has been seen."""
        return self._lasting > self._limit

    @property
    def in_window(self) -> bool:
        """Whether the samples of the window still have the peak: else it is told by the memory of the fit."""
        return self._in_window > self._limit

    def long_ago(self, time: float) -> bool:
        """Whether it was first passed long enough before `time`, on the clock of the nodes [s]."""
        return time - self._since >= _LEAST_AGE
