"""Slow adaptation of a tyre's gains to the motion of the car (not in the chapter).

Temperature and wear change the stiffness of a tyre, and its angles with it. Two things are watched:

- While the car rolls steadily each wheel carries its static load: the length of its patch over that of the calibration.
- The acceleration of the car gives each wheel's share of mass times acceleration (by brake torques
  while braking): the force of the map is x (1 + g + e) + o + d (omega - omega_0), with x the share, g the gain, o the
  error of the zero, and d a change of the radio's delay, which grows with speed. e is the error of the share itself,
  one for driving and one for braking: it is not the tyre's, and not learned away.

What has not been learned is in the deviations of the forces.
"""

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.calibration import TyreCalibration, polynomial
from smart_tyre_forces.car_reference import Reference
from smart_tyre_forces.correction import Patch
from smart_tyre_forces.forces import shift_stddev, turn_rate
from smart_tyre_forces.tyre_gain import TyreGain

Array = NDArray[np.float64]

_GAIN_STDDEV = 0.14
"""Relative deviation of a tyre's gain from the calibration before anything is learned: 20 % lie within 1.5 of it."""
_DELAY_STDDEV = 3e-5
"""Deviation of the change of the radio's delay [s]."""
_SURE = 4.0
"""Deviations of a change of the delay from which it is reported."""
_ZERO_REVOLUTIONS = 30
"""Revolutions from which the zero of the shift comes: its scatter is that much smaller."""
_STEADY = 0.3
"""Acceleration below which a car rolls steadily [m/s^2]."""
_DRIVING, _BRAKING = 0.8, -2.0
"""Accelerations from which the engine or the brakes alone act [m/s^2]."""
_SHARE_STDDEV = 0.03
"""Relative standard deviation of the force of one wheel from the acceleration, between revolutions."""
_STEADY_SHARE = 0.3
"""Relative standard deviation of the small forces of a steadily rolling car: their distribution is uncertain."""
_CORRELATED = 2.0
"""Factor of the variance of an observation: those of neighbouring revolutions err alike."""
_MEMORY = 400
"""Revolutions over which the length is averaged: about a minute of driving."""
_LENGTH_FLOOR = 0.003
"""Least relative deviation of the mean length."""
_SCATTER_MEMORY, _SCATTER_PRIOR = 60, 5
"""Revolutions over which the scatter of the shift is averaged, and those that the calibration counts for."""
_LEVEL_MEMORY = 20
"""Revolutions of steady rolling over which the shift is averaged, about which it scatters."""
_GAIN_DRIFT = 0.02 / np.sqrt(600.0)
"""Growth of the gain's deviation with time [1/sqrt(s)]: 2 % in ten minutes."""
_ZERO_DRIFT = 10.0 / np.sqrt(60.0)
"""Growth of the zero's deviation with time [N/sqrt(s)]."""


class GainWatch:
    """Learns the gain of one tyre."""

    def __init__(self, tyre: TyreCalibration, reference: Reference) -> None:
        """Start with what may be wrong with a tyre."""
        self._tyre, self._reference = tyre, reference
        slope = tyre.length_map.slope(reference.static_load)
        self._expected = float(tyre.length_map.angle(reference.static_load))
        exponent = reference.static_load / (slope * self._expected)
        """Relative change of length over that of load."""
        self._length_prior = exponent * _GAIN_STDDEV
        self._reference_stddev = exponent * reference.load_stddev
        self._lengths, self._mean, self._variance = 0, 0.0, 0.0
        force_slope = tyre.shift_map.slope(0.0)
        zero = force_slope * tyre.jitter_stddev / np.sqrt(_ZERO_REVOLUTIONS)
        common = reference.common_stddev**2
        self._x = np.zeros(5)
        """g, error of the share in driving and in braking, o, d."""
        self._p = np.diag(
            [
                _GAIN_STDDEV**2,
                common + reference.driving_stddev**2,
                common + reference.braking_stddev**2,
                zero**2,
                (force_slope * _DELAY_STDDEV) ** 2,
            ]
        )
        self._p[1, 2] = self._p[2, 1] = common
        self._excess, self._weight = 0.0, 0.0
        self._level, self._levels = 0.0, 0

    @property
    def gain(self) -> TyreGain:
        """What is known now."""
        measured = np.hypot(self._reference_stddev, self._length_error)
        share = self._length_prior**2 / (self._length_prior**2 + measured**2) if self._lengths else 0.0
        kept = [0, 3, 4]
        return TyreGain(
            length=1.0 + share * self._mean,
            length_stddev=float(np.sqrt(1.0 - share)) * self._length_prior,
            force=self._x[kept],
            covariance=self._p[np.ix_(kept, kept)],
            scatter=max(self._excess, 0.0) / self._weight if self._weight else self._tyre.load_scatter,
        )

    @property
    def delay_change(self) -> float:
        """By how much the delay of the acceleration differs from that of the calibration [s]; 0 where it may not."""
        change = float(self._x[4])
        if abs(change) < _SURE * np.sqrt(self._p[4, 4]):
            return 0.0
        return change / self._tyre.shift_map.slope(0.0)

    @property
    def _length_error(self) -> float:
        if self._lengths < 2:
            return np.inf
        return float(np.hypot(np.sqrt(_CORRELATED * self._variance / self._lengths), _LENGTH_FLOOR))

    def see(
        self, patch: Patch, acceleration: float, share: float | None, steady: float, zero_speed: float, dt: float
    ) -> None:
        """Take one valid revolution.

        Args:
            patch: contact patch.
            acceleration: of the car while it was there [m/s^2], forward positive.
            share: Fx of this wheel by the acceleration [N]; None where it is not known.
            steady: part of it that the speed trend removes [N].
            zero_speed: v_0 [m/s].
            dt: time since the last one [s].
        """
        rolling = abs(acceleration) < _STEADY
        if rolling:
            self._see_length(patch)
            self._see_scatter(patch)
        else:
            self._levels = 0
        if share is not None and (rolling or acceleration > _DRIVING or acceleration < _BRAKING):
            self._see_force(patch, acceleration, share, steady, zero_speed, dt, rolling)

    def _see_length(self, patch: Patch) -> None:
        trend = polynomial(self._tyre.length_trend, patch.speed) - self._tyre.nominal_length
        ratio = (patch.length + trend) / (self._expected + trend) - 1.0
        self._lengths = min(self._lengths + 1, _MEMORY)
        step = ratio - self._mean
        self._mean += step / self._lengths
        self._variance += (step**2 - self._variance) / self._lengths

    def _see_scatter(self, patch: Patch) -> None:
        """Take the scatter about the mean shift.

        That between neighbouring revolutions would be less: where a revolution takes as long as some swings of a wheel
        on its tyre, the road's load comes in the same phase again.
        """
        step = patch.shift - self._level
        if self._levels:
            time = patch.length_raw / patch.passage.wheel_speed
            excess = step**2 * self._levels / (self._levels + 1.0) - shift_stddev(self._tyre, patch) ** 2
            kept = 1.0 - 1.0 / _SCATTER_MEMORY
            if not self._weight:
                self._weight = _SCATTER_PRIOR * time**4
                self._excess = self._tyre.load_scatter * self._weight
            # Least squares of the excess over the square of the time: fast revolutions carry little information on it.
            self._excess = kept * self._excess + excess * time**2
            self._weight = kept * self._weight + time**4
        self._levels = min(self._levels + 1, _LEVEL_MEMORY)
        self._level += step / self._levels

    def _see_force(
        self,
        patch: Patch,
        acceleration: float,
        share: float,
        steady: float,
        zero_speed: float,
        dt: float,
        rolling: bool,
    ) -> None:
        force = self._tyre.shift_map.force(patch.shift)
        if not np.isfinite(force):
            return
        self._p[0, 0] += _GAIN_DRIFT**2 * dt
        self._p[3, 3] += _ZERO_DRIFT**2 * dt
        x = share - steady
        turn = turn_rate(patch, zero_speed)
        h = np.array([x, x * (acceleration > 0.0), x * (acceleration <= 0.0), 1.0, turn])
        slope = self._tyre.shift_map.slope(force)
        noise = slope * np.hypot(shift_stddev(self._tyre, patch), self.gain.load_scatter(patch)[0])
        doubt = _STEADY_SHARE * abs(share) if rolling else _SHARE_STDDEV * abs(x)
        ph = self._p @ h
        variance = float(h @ ph) + _CORRELATED * (noise**2 + doubt**2)
        self._x = self._x + ph * ((force - x - float(h @ self._x)) / variance)
        self._p = self._p - np.outer(ph, ph) / variance
