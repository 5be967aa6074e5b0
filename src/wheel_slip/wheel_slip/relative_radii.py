"""Radii of the wheels relative to each other, learned while the car rolls without force.

    ln(r_i omega_i) = ln v - e_i + s_i u + t_i d + n_i

e_i is the error of the radius r_i of the vehicle file, as a share. v is free, so only differences of the e_i are seen.
u is what a curve does to the sides (s_i = -1 left, 1 right): half the track times the curvature, which the lateral
acceleration of a car limits the more the faster it is. d is the slip by the little force that is left: of the driven
wheels where some are driven and some not, else of the rear axle (t_i = 1, others 0). u and d come and go, e stays: a
Kalman filter without a prior of e takes them apart.

What the vehicle file says of the radii is the prior that its result is weighed with: either all wheels are as it says,
or one of them is far off (another tyre, a flat one). Each of these cases gets its probability, and the radii and their
variances are those of all cases together: while a slow curve leaves open which wheel it is, the variances say so.
"""

from collections.abc import Sequence
from math import exp

import numpy as np
from numpy.typing import NDArray

from vehicle_models.vehicle import REAR, STATED, Vehicle, specified_stddev
from wheel_slip.free_rolling import Stretch

Array = NDArray[np.float64]

_UNSTATED = 0.5 * STATED["radius"]
"""Deviation of a radius from the others, as a share, where the file states none: half is what all have in common."""
_LEAST_DEVIATION = 0.001
"""The smallest one that is taken from a file, as a share: tyres do not warm up alike."""
_OPEN = 0.2
"""Deviation of a radius, as a share, in what the wheels alone say: more than tyres that fit, so that no file counts."""
_ANY_SPEED = 1.0
"""Deviation of the logarithm of the speed [-]: that of any speed, against which no radius weighs."""
_LATERAL = 2.5
"""Lateral acceleration of a car in traffic, standard deviation [m/s^2]: a quarter of the grip of a dry road."""
_TIGHTEST = 0.1
"""Curvature of slow turns, standard deviation [1/m]: a street corner has a radius of 10 m."""
_CURVE_TIME = 4.0
"""Time in which a curve comes and goes [s]: 55 m of a country road."""
_SLIP_PER_FORCE = 0.008
"""Slip of the driven wheels per force of all tyres over the mass [s^2/m]: half the weight, slip stiffness of 25."""
_SLIP_DEVIATION = (0.003, 0.015)
"""Its standard deviation without force, and per force [s^2/m]: soft snow, the offset of the accelerometer."""
_SLIP_TIME = 20.0
"""Time in which that slip changes [s]: the drag of a road speed, the pull of a gear."""
_NOISE = 0.001
"""Deviation of the mean of one stretch (free_rolling.py), as a share: bumps; noise of the wheel speeds at 3 m/s."""
_WALK = 1e-4
"""Change of a radius in the square root of a second, as a share: temperature, a slow puncture."""
_FAR = 0.05
"""Deviation of the radius of a wheel that is far off, as a share: worn out, another size, hardly any air."""
_RARE = 1e-3
"""Probability that one certain wheel is far off: one car in 250."""
_SURE = 0.95
"""Probability from which on a wheel is named: that of every interval stated here."""
_NAMED = 0.01
"""Smallest error of a radius that is named, as a share: more than wear and pressure of a car that is looked after."""


class RelativeRadii:
    """Radii of one car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Start with the radii of the vehicle file."""
        wheels = vehicle.wheels
        self._nominal = vehicle.radii
        self._names = vehicle.wheel_names
        self._half_track = 0.5 * vehicle.track
        stated = [
            _UNSTATED if (found := specified_stddev(each.deviations, "radius")) is None else found / each.radius
            for each in wheels
        ]
        self._stddevs: Array = np.maximum(np.array(stated), _LEAST_DEVIATION)
        sides = [-1.0 if each.side == "left" else 1.0 for each in wheels]
        some_driven = len({each.driven for each in wheels}) > 1
        slips = [each.driven if some_driven else each.axle == REAR for each in wheels]
        self._expected_slip = _SLIP_PER_FORCE if some_driven else 0.0
        self._h: Array = np.column_stack([-np.eye(len(wheels)), sides, np.array(slips, dtype=np.float64)])
        self._noise: Array = _NOISE**2 * np.eye(len(wheels)) + _ANY_SPEED**2
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        count = len(self._nominal)
        self._x: Array = np.zeros(count + 2)
        self._p: Array = np.diag([_OPEN**2] * count + [0.0, 0.0])
        self._seen = False
        self._combine()

    def update(self, stretch: Stretch) -> None:
        """Learn from a stretch without force; its rim speeds are those with the radii of the vehicle file."""
        if len(self._nominal) < 2:
            return
        logarithms = np.log(np.array(stretch.rim_speeds))
        speed = float(np.median(stretch.rim_speeds))
        curve = self._half_track * min(_TIGHTEST, _LATERAL / speed**2)
        slip = _SLIP_DEVIATION[0] + _SLIP_DEVIATION[1] * abs(stretch.force)
        count = len(self._nominal)
        for index, deviation, lasting in ((count, curve, _CURVE_TIME), (count + 1, slip, _SLIP_TIME)):
            stay = exp(-stretch.seconds / lasting) if self._seen else 0.0
            self._x[index] *= stay
            self._p[index, :] *= stay
            self._p[:, index] *= stay
            self._p[index, index] += (1.0 - stay * stay) * deviation**2
        self._p[:count, :count] += _WALK**2 * stretch.seconds * np.eye(count)
        self._seen = True
        expected = self._h[:, -1] * self._expected_slip * stretch.force
        # The mean logarithm is taken off first: it is the speed, and its size would cost digits.
        innovation = logarithms - logarithms.mean() - expected - self._h @ self._x
        ph = self._p @ self._h.T
        gain = np.linalg.solve(self._h @ ph + self._noise, ph.T).T
        self._x = self._x + gain @ innovation
        self._p = self._p - gain @ ph.T
        self._p = 0.5 * (self._p + self._p.T)
        self._combine()

    def _combine(self) -> None:
        """Weigh what was seen with the vehicle file: all wheels are as it says, or one is far off."""
        count = len(self._nominal)
        seen, seen_covariance = self._x[:count], self._p[:count, :count]
        relative = np.eye(count) - 1.0 / count
        weights, means, covariances = np.zeros(count + 1), np.zeros((count + 1, count)), []
        for case in range(count + 1):
            prior = np.diag(self._stddevs**2)
            if case < count:
                prior[case, case] += _FAR**2
            total = prior + seen_covariance
            gain = np.linalg.solve(total, prior).T
            means[case] = gain @ seen
            covariances.append(relative @ (prior - gain @ prior) @ relative)
            weights[case] = -0.5 * (seen @ np.linalg.solve(total, seen) + np.linalg.slogdet(total)[1])
        weights += np.log([_RARE] * count + [1.0])
        weights = np.exp(weights - weights.max())
        weights /= weights.sum()
        found = weights @ means
        variances, between = np.zeros(count), np.zeros((count, count))
        for weight, mean, covariance in zip(weights, means, covariances, strict=True):
            variances += weight * (np.diag(covariance) + (relative @ (mean - found)) ** 2)
            between += weight * (covariance + np.outer(mean - found, mean - found))
        self.radii = tuple([float(each) for each in np.array(self._nominal) * np.exp(found)])
        """Most likely radii [m]."""
        self.variances: Sequence[float] = [float(each) for each in variances]
        """Variances of the radii relative to their mean, as shares [-]."""
        self.covariance: Sequence[Sequence[float]] = between.tolist()
        """Covariance of the radii as shares [-], without what the vehicle file leaves open for all of them alike."""
        self.text = self._describe(found, weights)
        """Names the wheel that is far from what the vehicle file says, empty where none is."""

    def _describe(self, errors: Array, weights: Array) -> str:
        for name, error, weight in zip(self._names, errors, weights[:-1], strict=True):
            if weight > _SURE and abs(error) > _NAMED:
                return (
                    f"{name}: its radius is {100.0 * abs(error):.1f} % {'below' if error < 0.0 else 'above'} that of "
                    "the vehicle file, beside the other wheels: another tyre, worn or flat? It is corrected"
                )
        return ""
