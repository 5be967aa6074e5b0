"""Calibration from recorded drives: tooth tables, speed trends, beta, force maps (section 8.4.4).

Reference forces come from the car's acceleration and load transfer; wheel-force transducers are not needed. Such a
reference does not include the unevenness of the road, so the maps are fitted as angle over force (see `force_map`).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from smart_tyre_forces.calibration import Calibration, Polynomial, TyreCalibration, WheelCalibration
from smart_tyre_forces.correction import Patch, PatchCorrection, ZeroParameters
from smart_tyre_forces.force_map import ForceMap
from smart_tyre_forces.forces import steady_force
from smart_tyre_forces.front_template import FrontTemplate
from smart_tyre_forces.patch_tracker import Passage, TrackerParameters
from smart_tyre_forces.wheel_run import ACCELERATING, WheelRun, missing
from vehicle_models.reason import Reason
from vehicle_models.vehicle import REAR, Vehicle
from vehicle_models.wheel_forces import wheel_forces

Array = NDArray[np.float64]

_STEADY = 0.05
"""Acceleration below which the scatter of the fronts is taken [m/s^2]."""


@dataclass(frozen=True)
class Points:
    """Valid passages of one drive and their reference forces, arrays of shape (n,)."""

    speed: Array
    """[m/s]"""
    acceleration: Array
    """Acceleration of the car [m/s^2]."""
    shift: Array
    """[rad]"""
    length: Array
    """[rad]"""
    fx: Array
    """[N]"""
    fz: Array
    """[N]"""
    front_stddev: Array
    """Standard deviation of a front from the noise of the signal [rad]."""
    patch_time: Array
    """Time between the fronts [s]."""


def quasi_static_trends(
    runs: list[WheelRun], car: Vehicle, parameters: TrackerParameters
) -> tuple[Polynomial, Polynomial, Polynomial, dict[str, float]]:
    """Return the speed trends of shift [rad], length [rad] and Fx [N] for all wheels (Figure 8.21), and residuals.

    The zero of the shift differs from wheel to wheel and from drive to drive, so each run has a constant of its own in
    the fit.

    Raises:
        ValueError: a run has no valid passage, or the speeds do not span 5 m/s.
    """
    points = [raw_points(run, car, parameters) for run in runs]
    speed = np.concatenate([p.speed for p in points])
    if np.ptp(speed) < 5.0:
        raise ValueError(f"quasi-static runs: speeds span {np.ptp(speed):.1f} m/s, at least 5 are needed")
    own = np.concatenate([np.full(len(p.speed), k) for k, p in enumerate(points)])
    design = np.stack([speed, speed**2, *(own == k for k in range(len(points)))], axis=1).astype(np.float64)
    shift = np.concatenate([p.shift for p in points])
    solution = np.linalg.lstsq(design, shift, rcond=None)[0]
    shift_left = shift - design @ solution
    length, length_left = _second_order(speed, np.concatenate([p.length for p in points]))
    force = np.linalg.lstsq(design, np.concatenate([p.fx for p in points]), rcond=None)[0]
    residuals = {
        "shift_trend_rad": float(np.sqrt(np.mean(shift_left**2))),
        "length_trend_rad": float(np.sqrt(np.mean(length_left**2))),
    }
    return (0.0, float(solution[0]), float(solution[1])), length, (0.0, float(force[0]), float(force[1])), residuals


def calibrate(
    quasi_static: list[WheelRun],
    dynamic: list[WheelRun],
    tooth_tables: dict[str, Array],
    car: Vehicle,
    parameters: TrackerParameters = TrackerParameters(),
    zero: ZeroParameters = ZeroParameters(),
    template: FrontTemplate | None = None,
) -> Calibration:
    """Calibrate all wheels from quasi-static and dynamic drives of front and rear wheels.

    Args:
        quasi_static: drives with very slow acceleration, and coasting down.
        dynamic: drives that begin with constant low speed, then accelerate and brake.
        tooth_tables: deviations of the crossings [rad] by the name of the wheel.
        car: the car, for the reference forces.
        parameters: parameters of the sensors.
        zero: conditions of a steady stretch.
        template: template of the fronts, stored in the result unchanged.

    Raises:
        ValueError: a drive lacks what it is needed for; the message names it.
    """
    shift_trend, length_trend, trend_force, residuals = quasi_static_trends(quasi_static, car, parameters)
    if lacks := missing(dynamic, parameters.sample_rate):
        raise ValueError(f"the {len(dynamic)} dynamic drives of the wheels lack {'; and '.join(lacks)}")
    speeds = np.linspace(parameters.minimum_speed, parameters.maximum_speed, 61, dtype=np.float64)
    steady = wheel_forces(car, speeds, np.zeros(len(speeds)))
    wheels = {
        run.wheel.name: WheelCalibration(
            tuple(float(d) for d in tooth_tables[run.wheel.name]),
            _second_order(speeds, steady.fx_rear if run.wheel.axle == REAR else steady.fx_front)[0],
        )
        for run in dynamic
    }
    identity = ForceMap((0.0, 1.0), -1.0, 1.0)
    tyre = TyreCalibration(
        shift_trend=shift_trend,
        length_trend=length_trend,
        nominal_length=length_trend[0],
        beta=0.0,
        jitter_stddev=0.0,
        load_scatter=0.0,
        length_map=identity,
        shift_map=identity,
        trend_force=trend_force,
    )
    # Beta depends on the share of force in the front's shift, the force map on beta: they settle in a few rounds.
    for _ in range(4):
        points = [corrected_points(run, tyre, wheels[run.wheel.name], car, parameters, zero) for run in dynamic]
        tyre = _fit_maps(tyre, points)
        tyre = replace(tyre, beta=tyre.beta + _beta_step(tyre, dynamic, points))
    points = [corrected_points(run, tyre, wheels[run.wheel.name], car, parameters, zero) for run in dynamic]
    tyre = _fit_maps(tyre, points)
    shift_left = [p.shift - tyre.shift_map.angle(p.fx) for p in points]
    length_left = [p.length - tyre.length_map.angle(p.fz) for p in points]
    residuals["shift_map_rad"] = float(np.sqrt(np.mean(np.concatenate(shift_left) ** 2)))
    residuals["length_map_rad"] = float(np.sqrt(np.mean(np.concatenate(length_left) ** 2)))
    jitter, load_scatter = _scatter(tyre, points, shift_left)
    tyre = replace(tyre, jitter_stddev=jitter, load_scatter=load_scatter, residuals=residuals)
    return Calibration(tyre, wheels, template)


def _scatter(tyre: TyreCalibration, points: list[Points], left: list[Array]) -> tuple[float, float]:
    """Return the scatter of one front [rad], and that of the shift by the load over the time squared [rad^2/s^2].

    Steady rolling at a low and a higher speed separates them: the load has longer to change at the low one.
    """
    of_fronts = 0.5 + 2.0 * tyre.beta**2
    squares, times = [], []
    for p, shift in zip(points, left, strict=True):
        rolling = np.abs(p.acceleration) < _STEADY
        slow = p.speed < np.mean(p.speed[rolling])
        for part in (rolling & slow, rolling & ~slow):
            if np.count_nonzero(part) > 2:
                squares.append((shift[part] - np.mean(shift[part])) ** 2 - of_fronts * p.front_stddev[part] ** 2)
                times.append(p.patch_time[part])
    time = np.concatenate(times)
    fronts, load = nnls(np.stack([np.full(time.shape, of_fronts), time**2], axis=1), np.concatenate(squares))[0]
    return float(np.sqrt(fronts)), float(load)


def _fit_maps(tyre: TyreCalibration, points: list[Points]) -> TyreCalibration:
    fx, shift = np.concatenate([p.fx for p in points]), np.concatenate([p.shift for p in points])
    fz, length = np.concatenate([p.fz for p in points]), np.concatenate([p.length for p in points])
    return replace(tyre, shift_map=ForceMap.fit(fx, shift, (1, 2, 3)), length_map=ForceMap.fit(fz, length, (0, 1, 2)))


def _beta_step(tyre: TyreCalibration, runs: list[WheelRun], points: list[Points]) -> float:
    """Return the change of beta that leaves no shift on an undriven tyre beyond what its small force explains.

    While the car accelerates, that is the front tyre of the chapter (8.19).
    """
    longer, left = [], []
    for run, p in zip(runs, points, strict=True):
        accelerating = (p.acceleration > ACCELERATING) & (not run.wheel.driven)
        longer.append((p.length - tyre.nominal_length)[accelerating])
        left.append((p.shift - tyre.shift_map.angle(p.fx))[accelerating])
    x, y = np.concatenate(longer), np.concatenate(left)
    return -float(x @ y / (x @ x))


def raw_points(run: WheelRun, car: Vehicle, parameters: TrackerParameters) -> Points:
    """Return the passages without any correction; the zero of the shift is that of the tooth table.

    Raises:
        ValueError: fewer than 10 passages are valid.
    """
    valid = [p for p in run.passages if p.reason is Reason.OK]
    if len(valid) < 10:
        raise ValueError(f"{run.wheel.name}: only {len(valid)} valid passages in a quasi-static run")
    shift = np.unwrap(np.array([p.centre for p in valid]))
    length = np.array([p.length for p in valid])
    return _points(run, valid, shift, length, car, parameters)


def corrected_points(
    run: WheelRun,
    tyre: TyreCalibration,
    wheel: WheelCalibration,
    car: Vehicle,
    parameters: TrackerParameters,
    zero: ZeroParameters,
) -> Points:
    """Return the corrected passages; Fx is relative to the force at zero shift.

    Raises:
        ValueError: fewer than 10 passages are valid.
    """
    correction = PatchCorrection(tyre, run.wheel.radius, parameters.sample_rate, zero)
    patches: list[Patch] = [correction.update(passage) for passage in run.passages]
    valid = [patch for patch in patches if patch.reason is Reason.OK]
    if len(valid) < 10:
        raise ValueError(f"{run.wheel.name}: only {len(valid)} valid passages after a steady stretch in a dynamic run")
    shift, length = np.array([p.shift for p in valid]), np.array([p.length for p in valid])
    points = _points(run, [p.passage for p in valid], shift, length, car, parameters)
    hidden = np.array([steady_force(tyre, wheel, float(v), correction.zero_speed) for v in points.speed])
    return replace(points, fx=points.fx - hidden)


def _points(
    run: WheelRun, valid: list[Passage], shift: Array, length: Array, car: Vehicle, parameters: TrackerParameters
) -> Points:
    wheel_speed = np.array([p.wheel_speed for p in valid])
    # The fronts pass half a patch before and after its centre.
    time = np.array([p.time for p in valid]) / parameters.sample_rate - 0.5 * length / wheel_speed
    acceleration = np.interp(time, run.time, run.acceleration)
    speed = wheel_speed * run.wheel.radius
    reference = wheel_forces(car, speed, acceleration)
    fx, fz = (
        (reference.fx_rear, reference.fz_rear) if run.wheel.axle == REAR else (reference.fx_front, reference.fz_front)
    )
    front_stddev = np.array([p.front_stddev for p in valid])
    return Points(speed, acceleration, shift, length, fx, fz, front_stddev, length / wheel_speed)


def _second_order(speed: Array, value: Array) -> tuple[Polynomial, Array]:
    """Fit a second-order polynomial by least squares; return it and the residuals."""
    design = np.vander(speed, 3, increasing=True)
    solution = np.linalg.lstsq(design, value, rcond=None)[0]
    return (float(solution[0]), float(solution[1]), float(solution[2])), value - design @ solution
