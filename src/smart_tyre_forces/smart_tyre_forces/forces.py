"""Fz and Fx of one wheel from its corrected contact patch, with their standard deviations.

Removing the speed trend removes the steady drag and rolling resistance with it: the shift map alone gives Fx relative
to constant speed. The part removed is known from the calibration and is added again unless it is switched off:

    Fx = f_x(delta phi) + Fx_wheel(v_0) + trend(v) - trend(v_0),

with Fx_wheel the force of this wheel at constant speed, where the shift was set to zero, and trend the mean of both
axles and of driving and coasting (when the tyres feel no drag) that went into the common speed map.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from smart_tyre_forces.calibration import TyreCalibration, WheelCalibration, polynomial
from smart_tyre_forces.correction import Patch, ZeroParameters
from smart_tyre_forces.tyre_gain import TyreGain
from vehicle_models.reason import Reason

_TEXTS: Final = {
    Reason.OK: "",
    Reason.NO_PATCH: "waiting for a valid contact patch",
    Reason.NOT_CALIBRATED: "not calibrated: give calibration_file",
    Reason.OUT_OF_RANGE: "outside the calibrated range: calibrate with larger forces",
}


@dataclass(frozen=True)
class Forces:
    """Forces of one revolution [N]; NaN where unknown."""

    reason: Reason
    fx: float = np.nan
    """Longitudinal force [N], forward positive."""
    fz: float = np.nan
    """Vertical force on the tyre [N], upwards positive."""
    fx_stddev: float = np.nan
    fz_stddev: float = np.nan

    @property
    def text(self) -> str:
        """The reason in words, empty where it is OK."""
        return _TEXTS[self.reason]


def steady_force(tyre: TyreCalibration, wheel: WheelCalibration, speed: float, zero_speed: float) -> float:
    """Return Fx [N] at zero shift and `speed` [m/s]; the shift was set to zero at `zero_speed` [m/s]."""
    removed = polynomial(tyre.trend_force, speed) - polynomial(tyre.trend_force, zero_speed)
    return polynomial(wheel.steady_force, zero_speed) + removed


def _front_stddev(tyre: TyreCalibration, patch: Patch) -> float:
    """Standard deviation of a front [rad]: jitter of the calibration, and noise on this passage."""
    return float(np.hypot(tyre.jitter_stddev, patch.passage.front_stddev))


def shift_stddev(tyre: TyreCalibration, patch: Patch) -> float:
    """Standard deviation of the corrected shift [rad]: half the sum of two fronts, and beta times their difference."""
    return _front_stddev(tyre, patch) * float(np.sqrt(0.5 + 2.0 * tyre.beta**2))


def zero_stddev(tyre: TyreCalibration, patch: Patch, zero_speed: float) -> float:
    """Standard deviation of the zero of the shift [rad]: the mean of the revolutions of its stretch at `zero_speed`."""
    turns = patch.passage.wheel_speed * zero_speed / patch.speed
    time = patch.length_raw / turns
    revolutions = max(ZeroParameters().duration * turns / (2.0 * np.pi), 1.0)
    return float(np.sqrt((shift_stddev(tyre, patch) ** 2 + tyre.load_scatter * time**2) / revolutions))


def length_stddev(tyre: TyreCalibration, patch: Patch) -> float:
    """Standard deviation of the length [rad]: difference of two fronts, and the error from a change of pressure."""
    return float(np.hypot(_front_stddev(tyre, patch) * np.sqrt(2.0), patch.length_bias))


def forces(
    patch: Patch,
    tyre: TyreCalibration | None,
    wheel: WheelCalibration | None,
    zero_speed: float,
    *,
    restore_steady: bool,
    gain: TyreGain | None = None,
) -> Forces:
    """Forces of one contact patch: Fz = f_z(Delta phi) (8.14), Fx = f_x(delta phi) (8.16) and the steady part.

    Args:
        patch: contact patch of this revolution.
        tyre: calibration with the maps; None when not calibrated.
        wheel: calibration with the steady force; None when not calibrated.
        zero_speed: v_0, at which the shift was set to zero [m/s].
        restore_steady: whether to add the steady part that the speed trend removed.
        gain: the tyre against its calibration; None: the calibration holds exactly.
    """
    if tyre is None or wheel is None:
        return Forces(Reason.NOT_CALIBRATED)
    if patch.reason is not Reason.OK:
        return Forces(Reason.NO_PATCH)
    known = gain or TyreGain(scatter=tyre.load_scatter)
    trend = polynomial(tyre.length_trend, patch.speed) - tyre.nominal_length
    fz = tyre.length_map.force((patch.length + trend) / known.length - trend)
    mapped = tyre.shift_map.force(patch.shift)
    if not (np.isfinite(fz) and np.isfinite(mapped)):
        return Forces(Reason.OUT_OF_RANGE)
    turn = turn_rate(patch, zero_speed)
    force = float((mapped - known.force[1] - known.force[2] * turn) / (1.0 + known.force[0]))
    effect = np.array([force, 1.0, turn]) / (1.0 + known.force[0])
    by_shift, by_length = known.load_scatter(patch)
    length = length_stddev(tyre, patch) if gain is None else _front_stddev(tyre, patch) * float(np.sqrt(2.0))
    length = float(np.hypot(np.hypot(length, by_length), known.length_stddev * (patch.length + trend)))
    zero = zero_stddev(tyre, patch, zero_speed) if gain is None else 0.0  # that of a gain is in its covariance
    shift = tyre.shift_map.slope(force) * float(np.sqrt(shift_stddev(tyre, patch) ** 2 + by_shift**2 + zero**2))
    return Forces(
        reason=Reason.OK,
        fx=force + (steady_force(tyre, wheel, patch.speed, zero_speed) if restore_steady else 0.0),
        fz=fz,
        fx_stddev=float(np.sqrt(shift**2 + effect @ known.covariance @ effect)),
        fz_stddev=tyre.length_map.slope(fz) * length,
    )


def turn_rate(patch: Patch, zero_speed: float) -> float:
    """Return omega - omega_0 [rad/s], by which a changed delay shows in the shift; v_0 [m/s] is the zero's speed."""
    return patch.passage.wheel_speed * (1.0 - zero_speed / patch.speed)
