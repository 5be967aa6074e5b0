"""Friction samples from measured tyre forces, mu = -Fx / Fz, and the curve fitted to them.

The forces of a smart tyre (section 8.4) need neither brake torque nor the wheel's inertia: their noise is that of the
forces alone, and an error common to Fx and Fz cancels. They come once per revolution, about ten per second.
"""

from dataclasses import dataclass
from math import isfinite

from friction_curve_id.chapter.curve_fitting import PointFitting
from friction_curve_id.chapter.friction_samples import LARGEST_FRICTION, FrictionPoint
from friction_curve_id.chapter.maximum_likelihood import MaximumLikelihood
from friction_curve_id.chapter.start_parameters import StartParameters
from friction_curve_id.interface import CurveEstimate, Refusal
from friction_parameters.parameter import constant
from vehicle_models.reason import Reason

_BRAKING_FRICTION = 0.02
"""mu [-] from which the brake counts as applied."""
_REPEATED = 1e-4
"""Samples closer than this count as repeated [s]."""


@dataclass(frozen=True)
class TyreForceSample:
    """Forces of one tyre with the slip at the same stamp. Anything may be garbage: it is refused."""

    time: float
    """Stamp [s]."""
    slip: float
    """[-], braking positive."""
    longitudinal_force: float
    """Fx [N], forward positive: negative in braking."""
    vertical_load: float
    """Fz [N]."""


@dataclass(frozen=True)
class TyreForceParameters(StartParameters):
    """When a fit begins, and which samples may enter it."""

    min_load: float = constant(200.0, "no friction from a vertical load below", unit="N")
    max_gap: float = constant(1.0, "longest time between two samples of an input that is bridged", unit="s")


class TyreForceFitting:
    """Curve of one wheel from its tyre forces by batch ML, one sample at a time."""

    def __init__(self, parameters: TyreForceParameters = TyreForceParameters()) -> None:
        """Wait for the first braking."""
        self._parameters = parameters
        self._fitting = PointFitting(MaximumLikelihood(), parameters)
        self._last: float | None = None

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._last = None
        self._fitting.reset()

    def update(self, sample: TyreForceSample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        p, last = self._parameters, self._last
        values = (sample.time, sample.slip, sample.longitudinal_force, sample.vertical_load)
        if not all(isfinite(value) for value in values):
            return Refusal(Reason.BAD_INPUT, "time, slip or a force is not finite")
        if not -1.0 < sample.slip < 1.0:
            return Refusal(Reason.NO_SLIP, f"slip {sample.slip:.2f} is outside (-1, 1)")
        if sample.vertical_load < p.min_load:
            return Refusal(Reason.BAD_INPUT, f"vertical load {sample.vertical_load:.0f} N is below {p.min_load:.0f} N")
        friction = -sample.longitudinal_force / sample.vertical_load
        if abs(friction) > LARGEST_FRICTION:
            return Refusal(Reason.BAD_INPUT, f"the forces give mu = {friction:.3g}")
        if last is not None and abs(sample.time - last) < _REPEATED:
            return Refusal(Reason.BAD_INPUT, f"stamp {sample.time:.6f} s repeats {last:.6f} s")
        after_gap = last is not None and not 0.0 < sample.time - last <= p.max_gap
        self._last = sample.time
        braking = friction > _BRAKING_FRICTION
        return self._fitting.update(FrictionPoint(sample.time, sample.slip, friction, braking, after_gap))
