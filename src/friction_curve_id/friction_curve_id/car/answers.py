"""Answers from the fits of a braking: the curve, the present slips on it, and why it is not valid."""

from math import exp, hypot, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.braking import EARLIEST_VALID, Braking
from friction_curve_id.car.combined_slip import share_across
from friction_curve_id.car.curve_family import Family, burckhardt_k, curve_values
from friction_curve_id.car.evidence import UNRESOLVED_HEIGHT, Peak, doubt, reaching_up
from friction_curve_id.car.present_slip import present_slip
from friction_curve_id.car.prior import SLIP_OFFSET_STDDEV
from friction_curve_id.car.tyre_deviations import LAMBDA_MAX, mu_max_deviations
from friction_curve_id.car.unknowns import Unknown
from friction_curve_id.car.wheel_equation import LOAD_VARIATIONS
from friction_curve_id.interface import UNKNOWN_THETA, CurveEstimate, RestartCause
from vehicle_models.reason import Reason

Array = NDArray[np.float64]

_LARGEST_STDDEV = 0.25
"""Largest deviation of lambda_max that is valid, and of a mu_max that is known alone, as a share [-]."""
_MOST_UNMEASURED = 0.03
"""Share of the friction along the wheels that a curve may take where nothing measures the motion across."""
_SURE = 2.0
"""Deviations by which a curve is at least as tight as it shows."""
_BETWEEN_ROADS = 1.0
"""Deviation of ln lambda_max and ln mu_max while the newest friction is that of another road."""
_SETTLED = 0.1
"""Step of ln lambda_max and ln mu_max below which a fit has settled."""


def answers(
    braking: Braking, time: float, speed: Array, gained: float, restart_cause: RestartCause
) -> list[CurveEstimate]:
    """Return the estimate of each wheel.

    Args:
        braking: the present one.
        time: present [s].
        speed: present wheel speeds [rad/s], shape (W,).
        gained: integral of the measured acceleration since the newest sample of the window [m/s].
        restart_cause: why the fit has restarted since the last answer.
    """
    road, count = braking.road, braking.samples.count
    peak = road.peak
    if peak is None:
        text = "waiting for the first fit of this braking"
        return [CurveEstimate(count, nan, restart_cause=restart_cause, text=text)] * len(speed)
    slips, slip_stddevs, beyond = _slips(braking, peak, time, speed, gained)
    reason, text = _reason(braking, peak, time)
    passed = reason is Reason.OK
    if passed:
        reason, text = _reason_of_lambda_max(peak, road.unresolved)
    road.astray.was_valid = road.astray.was_valid or reason is Reason.OK
    lambda_max, mu_max = exp(peak.log_lambda_max), exp(peak.log_mu_max)
    best = peak.likeliest
    surprised = road.astray.unexplained or bool(road.two_roads)
    fit, family = braking.fits[best], braking.families[best]
    shape = (float(fit.unknowns[Unknown.SHAPE_1]), float(fit.unknowns[Unknown.SHAPE_2]))
    curve = curve_values(family, peak.log_lambda_max, shape, slips / lambda_max)
    mu, slope = mu_max * curve.value, mu_max / lambda_max * curve.slope
    of_lambda, of_mu = 0.0, np.zeros(len(speed))
    between = _BETWEEN_ROADS if road.watch.changes else 0.0
    if len(braking.fits) > 1:  # with one formula given, the tyres are given to be of it
        of_lambda, of_mu = LAMBDA_MAX, mu_max_deviations(fit.moved, fit.tyres)
    log_mu_stddev = hypot(peak.log_mu_stddev, road.misfit, UNRESOLVED_HEIGHT * road.unresolved, between)
    mu_stddevs = [reaching_up(hypot(log_mu_stddev, float(each))) for each in of_mu]
    theta = burckhardt_theta(peak, shape[0]) if family is Family.BURCKHARDT else UNKNOWN_THETA
    return [
        CurveEstimate(
            count,
            float(slips[each]),
            lambda_max,
            mu_max,
            lambda_max * hypot(peak.log_lambda_stddev, road.unresolved, of_lambda, between),
            mu_max * mu_stddevs[each],
            theta,
            mu=float(mu[each]),
            slope=float(slope[each]),
            probability_beyond_peak=nan if surprised else beyond[each],
            restart_cause=restart_cause,
            reason=reason,
            text=text,
            slip_stddev=float(slip_stddevs[each]),
            mu_max_known=passed and mu_stddevs[each] < _LARGEST_STDDEV,
        )
        for each in range(len(speed))
    ]


def _slips(braking: Braking, peak: Peak, time: float, speed: Array, gained: float) -> tuple[Array, Array, list[float]]:
    """Return present slips with their deviations, and the probabilities that they are beyond the peak."""
    wheels, fits = len(speed), braking.fits
    mean, square = np.zeros(wheels), np.zeros(wheels)
    beyond = [0.0] * wheels
    seen = braking.road.passing.in_window
    factor, floor = doubt(seen, len(fits) == 1)
    if not seen:  # a formula may be as wrong as the two of them differ
        log_peaks = [float(fit.unknowns[Unknown.LOG_LAMBDA_MAX]) for fit in fits]
        floor = hypot(floor, max(log_peaks) - min(log_peaks))
    changed = float(braking.samples.speed_change[-1]) + gained
    yaw_rate = float(braking.samples.yaw_rate[-1])
    for weight, fit, (since, changed_then) in zip(peak.weights, fits, braking.newest, strict=True):
        slip, variance, probability = present_slip(
            braking.car, fit, time - since, changed - changed_then, speed, yaw_rate, factor, floor
        )
        mean += weight * slip
        square += weight * (slip**2 + variance)
        for each in range(wheels):
            beyond[each] += weight * probability[each]
    # a sum of weights may be more than 1 in its last bit
    return mean, np.sqrt(np.maximum(square - mean**2, 0.0)), [min(each, 1.0) for each in beyond]


def _reason(braking: Braking, peak: Peak, time: float) -> tuple[Reason, str]:
    """Return why neither lambda_max nor mu_max may be used, OK where one of them may."""
    road, best = braking.road, peak.likeliest
    since = time - road.began_at
    if since < EARLIEST_VALID and road.earliest_valid == EARLIEST_VALID:
        return Reason.NOT_READY, f"waiting for {EARLIEST_VALID} s of braking"
    if _in_unmeasured_curve(braking, peak):
        return Reason.UNCERTAIN, "in a curve: yaw rate or lateral acceleration is missing, check imu/data"
    if not road.passing.begun:
        return Reason.PEAK_NOT_PASSED, "waiting for a wheel to pass the peak"
    if not (road.passing.seen and road.passing.long_ago(time - braking.start.time)):
        return Reason.PEAK_NOT_PASSED, "a wheel has just passed the peak: waiting for 0.1 s beyond it"
    if since < road.earliest_valid:
        return Reason.UNCERTAIN, f"waiting for {road.earliest_valid} s on the new road"
    if road.astray.unexplained or not road.astray.calm(time):
        return Reason.UNCERTAIN, "the car does not move as its vehicle file says: run vehicle_doctor"
    if braking.measured_across and braking.lateral.slides:
        return Reason.UNCERTAIN, "the car slides sideways"
    if road.two_roads:
        return Reason.UNCERTAIN, road.two_roads
    if road.moves[best] > _SETTLED:
        return Reason.UNCERTAIN, "waiting for the fit to settle"
    if braking.fits[best].load_variation == LOAD_VARIATIONS.size - 1:
        return Reason.UNCERTAIN, "the wheels follow no common curve: run vehicle_doctor"
    return Reason.OK, ""


def _in_unmeasured_curve(braking: Braking, peak: Peak) -> bool:
    """Return whether the wheels show a curve that surely takes much of the friction, and nothing measures it."""
    fit = braking.fits[peak.likeliest]
    if braking.measured_across or fit.steps == 0:
        return False
    turned = float(fit.unknowns[Unknown.CURVE] + fit.unknowns[Unknown.CURVE_RATE] * fit.newest)
    of_both, curve, rate = fit.covariance, Unknown.CURVE, Unknown.CURVE_RATE
    variance = of_both[curve, curve] + fit.newest * (2.0 * of_both[curve, rate] + fit.newest * of_both[rate, rate])
    stddev = hypot(sqrt(max(float(variance), 0.0)), SLIP_OFFSET_STDDEV)
    least = max(abs(turned) - _SURE * stddev, 0.0)
    across = share_across(least, float(fit.moved.speed[-1]), braking.car, exp(peak.log_mu_max))
    return 0.5 * across**2 > _MOST_UNMEASURED


def _reason_of_lambda_max(peak: Peak, unresolved: float) -> tuple[Reason, str]:
    stddev = hypot(peak.log_lambda_stddev, unresolved)
    if stddev > _LARGEST_STDDEV:
        return Reason.UNCERTAIN, f"waiting for slips around the peak: lambda_max has a deviation of {stddev:.0%}"
    return Reason.OK, ""


def burckhardt_theta(peak: Peak, u: float) -> Array:
    """Return the parameters of (2.13) of a Burckhardt curve with this peak, shape (3,)."""
    k = burckhardt_k(peak.log_lambda_max, u)
    lambda_max = exp(peak.log_lambda_max)
    theta_1 = exp(peak.log_mu_max) / (1.0 - exp(-k) - k * exp(-k))
    return np.array([theta_1, k / lambda_max, theta_1 * k * exp(-k) / lambda_max])
