"""Change of every tyre's slip over its force: along its curve, beyond its peak, and back.

Where the force stays, slip over force stays. Where a tyre bends, at its peak, its slip creeps; where it dives, its slip
goes on as fast as it goes. What such a change makes of slip over force is bounded: a tyre whose wheel comes back gives
a share f of the largest force that it gave, and its slip over force is then that of the same share of its curve,

    F = D (1 - e^(-s / s_0)),    s / F = (s_0 / D) (-ln(1 - f) / f)

with the doubt that the largest force was that of this road, and that the tyre is an ordinary one. With the probability
that f is that of a tyre beyond its peak, the slip goes towards s. That is one state of all tyres: it may be anything up
to a locked wheel's, but tyres on one road that slide under one law slide alike. Four of them are then one piece of
evidence and not four, and what s was while the speed was known counts afterwards. So a wheel whose brake is released
shows the speed as soon as it has sprung back, whatever it has done before, and wheels that go on sliding do not.
"""

from math import erf, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wheel_slip.motion_noise import MotionNoise
from wheel_slip.tyre_forces import SLOWEST, TELLING, Forces

Array = NDArray[np.float64]

_SATURATION: Final = np.linspace(1e-3, 4.5, 200)
"""Slips of a tyre, over s_0."""
_SHARE: Final = -np.expm1(-_SATURATION)
"""Shares f of the largest force at these."""
_RATIO: Final = _SATURATION / _SHARE
"""Slip over force at these, over that of little slip."""
_BEND: Final = np.exp(_SATURATION) / _RATIO - 1.0
"""Relative change of slip over force with that of the force at these."""
_FULL: Final = 0.95
"""Share from which on a tyre may be beyond its peak."""
_ANY_ROAD: Final = 1.0
"""Force over load times g [m/s^2] that any road gives but wet ice."""


class SlipChange(NamedTuple):
    """Of slip over force c of all tyres in a step, to kept c + (1 - kept)(towards + by s); shapes (2, wheels)."""

    kept: Array
    towards: Array
    """[s^2/m]"""
    by: Array
    """Change of that with the slip s of tyres beyond their peak [s^2/m]."""
    variance: Array
    """Of what comes to it [s^4/m^2]."""


class TyreSlip:
    """Of all tyres of a car."""

    def __init__(self, count: int, noise: MotionNoise) -> None:
        """Start with `count` wheels that roll."""
        self._noise, self._count = noise, count
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.force = np.zeros((2, self._count))
        """Force of every tyre over its load, times g [m/s^2], braking positive, shape (2, wheels)."""
        self.unrest = np.zeros((2, self._count))
        """By how much every wheel changes unlike the car, until tyre and pressure follow [m/s^2], shape (2, wheels)."""
        self._largest, self._doubt = np.full((2, self._count), _ANY_ROAD), np.zeros((2, self._count))

    def disturb(self, dt: float, rest: Array, settles: Array) -> None:
        """Take by how much wheels change unlike the car [m/s^2], and the time in which their forces settle [s].

        Shapes (wheels,) and (2, wheels).
        """
        share = dt / (settles + dt)
        self.unrest = np.maximum(rest, np.sqrt(self.unrest**2 + share * (rest**2 - self.unrest**2)))

    def change(
        self, dt: float, speed: float, forces: Forces, compliance: Array, unlike: Array, locked: NDArray[np.bool_]
    ) -> SlipChange:
        """Take the forces of a step; return what becomes of slip over force.

        Args:
            dt: length of the step [s].
            speed: of the car [m/s].
            forces: that are measured; a change of them within their noise is not one of the tyre.
            compliance: slip over force, no less than is expected [s^2/m].
            unlike: acceleration of the car less that of every rim, beyond its noise [m/s^2].
            locked: which wheels stand.
        """
        p, fast, step = self._noise, max(abs(speed), SLOWEST), forces.force - self.force
        change = step**3 / (step**2 + forces.fleeting**2)
        self.force = self.force + change
        size = np.abs(self.force)
        weight = np.maximum(size, TELLING)
        dive = np.where(forces.told, np.maximum(self.unrest - p.steepest, 0.0), self.unrest)
        bend = np.interp(compliance / p.compliance, _RATIO, _BEND)
        grown = (dive / (fast * weight)) ** 2 * (p.dive_time * dt)
        grown += ((bend / (1.0 + bend)) ** 2 * p.creep / (fast * weight)) ** 2 * dt
        grown += (compliance * change / weight) ** 2 * max(p.correlation / dt, 1.0)
        further = np.maximum(unlike * np.sign(speed * self.force), 0.0) * dt / (fast * p.another)
        again = np.where((size >= self._largest) | locked, 1.0, np.minimum(further, 1.0))
        self._largest = self._largest + again * (size - self._largest)
        self._doubt = self._doubt + again * (forces.doubt - self._doubt)
        towards, by, bound = self._on_curve(size, weight)
        share = np.where(locked, 1.0, np.minimum(grown / bound, 1.0))
        share = np.where(forces.told | (self._largest <= _ANY_ROAD), share, 0.0)
        return SlipChange(np.sqrt(1.0 - share), towards, by, np.where(share > 0.0, share * bound, grown))

    def _on_curve(self, size: Array, weight: Array) -> tuple[Array, Array, Array]:
        """Return slip over force, its change with s, and its variance, by the share of the largest force of each."""
        p, largest = self._noise, np.maximum(self._largest, 1e-6)
        share = size / largest
        unsure = np.minimum(np.hypot(p.share, self._doubt / largest), 1.0) * share + 1e-9
        past = np.array([0.5 + 0.5 * erf(each / sqrt(2.0)) for each in ((share - _FULL) / unsure).flat])
        past = past.reshape(share.shape)
        below = p.compliance * np.interp(np.minimum(share, _FULL), _SHARE, _RATIO)
        beyond, spread = p.slide / weight, sqrt(1.0 - p.slide_alike) * p.slide_stddev / weight
        variance = (1.0 - past) * (p.compliance_unlike * below) ** 2 + past * spread**2
        return (1.0 - past) * below, past / weight, variance + past * (1.0 - past) * (beyond - below) ** 2
