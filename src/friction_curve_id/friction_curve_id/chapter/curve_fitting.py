"""From friction samples to estimates: when a fit starts, when it starts again, and its result.

The start is that of section 8.3: a fit begins once `initial_samples` friction samples are there and the slip exceeds
`lambda_init` (0 and 20 in Tables 8.1 to 8.3; 0.07 in Tables 8.4 and 8.5, where the samples before it are the
initialisation period). A fit lasts for one braking: the next begins a new one, on whatever road that is.
"""

from collections import deque
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples
from friction_curve_id.chapter.start_parameters import StartParameters
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause, Sample
from vehicle_models.reason import Reason

Array = NDArray[np.float64]

_LEAST_SLIP_SPAN: Final = 0.003
"""Least range of slip over the first samples [-]; with less there is nothing to fit."""
_RELEASE_TIME: Final = 0.5
"""A brake released for longer than this ends the fit [s]."""
_RELEASED = Refusal(Reason.NO_EXCITATION, "the brake is released")


class CurveFit(Protocol):
    """A method of section 8.3, on friction samples."""

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with the first samples, shapes (n,)."""
        ...

    def add(self, slip: float, friction: float) -> object:
        """Take one more sample."""
        ...

    def curve(self) -> FittedCurve:
        """The curve so far."""
        ...


class PointFitting:
    """Runs a `CurveFit` on friction points."""

    _LONGEST_WAIT = 400

    def __init__(self, fit: CurveFit, start: StartParameters = StartParameters()) -> None:
        """Wait for the first braking."""
        self._fit = fit
        self._start = start
        self._cause = RestartCause.NONE
        self._waiting: deque[FrictionPoint] = deque(maxlen=self._LONGEST_WAIT)
        self._count = 0
        self._largest_slip = 0.0
        self._released_since: float | None = None

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._clear()
        self._cause = RestartCause.REQUEST

    def update(self, point: FrictionPoint) -> CurveEstimate | Refusal:
        """Take the next point."""
        if point.after_gap:
            if self._cause is RestartCause.NONE and (self._count or self._waiting):
                self._cause = RestartCause.GAP
            self._clear()
        if not self._is_braking(point):
            return _RELEASED
        if self._count == 0:
            refusal = self._wait(point)
            if refusal is not None:
                return refusal
        else:
            self._fit.add(point.slip, point.mu)
            self._count += 1
            self._largest_slip = max(self._largest_slip, point.slip)
        estimate = self._fit.curve().estimate(point.slip, self._count, self._largest_slip)
        cause, self._cause = self._cause, RestartCause.NONE
        return estimate if cause is RestartCause.NONE else estimate._replace(restart_cause=cause)

    def _clear(self) -> None:
        self._waiting.clear()
        self._count = 0
        self._largest_slip = 0.0
        self._released_since = None

    def _is_braking(self, point: FrictionPoint) -> bool:
        """A short release belongs to the braking: so do the first samples, before the torque has risen."""
        if point.braking:
            if self._released_since is not None and self._has_ended(point.time):
                self._clear()
            self._released_since = None
            return True
        if self._released_since is None:
            self._released_since = point.time
        return not self._has_ended(point.time)

    def _has_ended(self, time: float) -> bool:
        return self._released_since is not None and time - self._released_since > _RELEASE_TIME

    def _wait(self, point: FrictionPoint) -> Refusal | None:
        """Collect the first samples; start the fit when they suffice."""
        self._waiting.append(point)
        count, needed = len(self._waiting), self._start.initial_samples
        if count < needed:
            return Refusal(Reason.NOT_READY, f"{count} of {needed} initial samples")
        slips = np.array([first.slip for first in self._waiting])
        span = float(np.ptp(slips))
        if span < _LEAST_SLIP_SPAN:
            return Refusal(Reason.NO_EXCITATION, f"the slip stays within {span:.4f}: nothing to fit")
        if point.slip <= self._start.lambda_init:
            return Refusal(Reason.NOT_READY, f"slip {point.slip:.3f} has not passed {self._start.lambda_init:.3f}")
        self._fit.start(slips, np.array([first.mu for first in self._waiting]))
        self._count, self._largest_slip = count, float(np.max(slips))
        self._waiting.clear()
        return None


class WheelFitting:
    """CurveEstimator of one wheel: friction samples, then a fit on them."""

    def __init__(self, samples: FrictionSamples, fit: CurveFit, start: StartParameters = StartParameters()) -> None:
        """Join a source of friction samples and a method."""
        self._samples = samples
        self._fitting = PointFitting(fit, start)

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._samples.reset()
        self._fitting.reset()

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        point = self._samples.update(sample)
        return point if isinstance(point, Refusal) else self._fitting.update(point)
