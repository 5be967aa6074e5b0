"""One braking: a fit for each family of curves, moved in turn, and the roads that they are on."""

from dataclasses import dataclass, field, replace
from math import exp, inf, isnan

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.astray import Astray
from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.combined_slip import shows_friction
from friction_curve_id.car.evidence import Peak, mixture, unresolved
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.lateral_motion import LateralMotion
from friction_curve_id.car.new_road import NewRoad, axle_on_new_road, friction_there, silenced, told_of_roads
from friction_curve_id.car.node_signals import Nodes, Start, delayed, node_signals
from friction_curve_id.car.one_road import LASTING, NEWEST, RoadWatch, misfit_at_peak, used_and_fitted
from friction_curve_id.car.parameters import CarEstimatorParameters
from friction_curve_id.car.passing import Passing
from friction_curve_id.car.prior import car_prior, radius_deviation
from friction_curve_id.car.tyre_deviations import side_deviations
from friction_curve_id.car.unknowns import Unknown
from sensor_monitor.signal_noise import white_noise
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

CAPACITY = 260
"""Most samples of the window."""
_FOLDED = 40
"""Samples that leave it at a time."""
_MEMORY = 3.0
"""Time with which what has left the window fades [s]."""
_STEP_INTERVAL = 0.0045
"""Least time between two Gauss-Newton steps for each wheel of the car [s]: what they cost goes with the wheels."""
_PROMISE = 20.0
"""Gain in ln of the likelihood that a step promises from which on steps come twice as often: the fit is on its way."""
_FIRST_STEP = 0.03
"""Time of braking before the first step [s]: a fast rise uses half of the friction after 0.08 s."""
_SAME_TIME = 1e-6
"""Times are equal within this [s]."""
EARLIEST_VALID, _EARLIEST_ANEW = 0.1, 0.5
"""Time of a braking, or on another road within it, before which nothing is valid [s]. There the axles come one after
the other, and most of what their wheels do first is too fast to tell."""
_ASTRAY, _STEPS_BACK = 50.0, 5
"""A fit that arrives where its log evidence is that much lower is in a minimum of its own; steps that it has for it."""
_LONGER = 2
"""What a fit that has gone back has to arrive once more, in its steps until then: its formula may be the wrong one."""
_KNOWN_MU = 0.1
"""Relative deviation of mu_max below which another road is told from the present one."""
_LEAST_WHEEL_STDDEV = 0.01
"""Least noise of a wheel speed [rad/s]."""


@dataclass
class Road:
    """What is known of the present road."""

    began_at: float
    """Stamp from which on it is known [s]."""
    earliest_valid: float
    """Time on it before which nothing is valid [s]."""
    moves: list[float]
    """Last step of ln lambda_max and ln mu_max of each fit."""
    may_go_back: list[int]
    """Steps that each fit has before it may begin where the best one is."""
    peak: Peak | None = None
    astray: Astray = field(default_factory=Astray)
    passing: Passing = field(default_factory=Passing)
    watch: RoadWatch = field(default_factory=RoadWatch)
    two_roads: str = ""
    """Why the wheels are not on one road; empty where they are."""
    misfit: float = 0.0
    """Relative misfit of mu_max at the peak."""
    unresolved: float = 0.0
    """Relative deviation of lambda_max by what lies between the samples."""


class Braking:
    """The fits of a braking."""

    def __init__(
        self,
        vehicle: Vehicle,
        parameters: CarEstimatorParameters,
        car: CarConstants,
        present: tuple[int, ...],
        samples: BrakingSamples,
        time: float,
        lateral: LateralMotion,
        with_accelerometer: bool,
        measured_across: bool,
    ) -> None:
        """Begin.

        Args:
            vehicle: the car with its deviations.
            parameters: of the estimator.
            car: its nominal values, with the wheels that are present.
            present: numbers of these wheels.
            samples: the window; at first the time before the braking.
            time: present [s].
            lateral: motion across the car.
            with_accelerometer: whether the acceleration is measured.
            measured_across: whether yaw rate and lateral acceleration are.
        """
        self.car, self.samples, self.lateral = car, samples, lateral
        self._vehicle, self._p, self._wheels = vehicle, parameters, len(present)
        few = min(3, samples.count)
        # A driven wheel slips under its engine before the brakes act: on soft snow by a fiftieth of the speed.
        free = car.driven[:, 0] == 0.0
        if not free.any():
            free[:] = True
        rolling = float((car.radius[free, 0] * samples.wheel_speed[free, :few].mean(axis=1)).mean())
        at_rest = float(samples.acceleration[: max(samples.count // 4, 1)].mean())
        self.start = Start(
            float(samples.time[0]), rolling, at_rest, float(samples.speed_change[0]), float(samples.sideways[0])
        )
        self._wheel_stddev = np.maximum(white_noise(samples.wheel_speed), _LEAST_WHEEL_STDDEV)
        self.measured_across = measured_across
        lateral.begin_braking()
        if not measured_across:
            samples.straighten()
        self.families = tuple(parameters.families())
        self.fits = [
            CurveFit(
                car,
                car_prior(
                    vehicle,
                    present,
                    shape,
                    parameters.slope_stddev,
                    with_accelerometer,
                    rolling if measured_across else None,
                    lateral.sideways - lateral.turned + float(samples.sideways[0]),
                ),
                family,
                parameters.torque_stddev,
                with_accelerometer and self._wheels == len(vehicle.wheels),
            )
            for family, shape in parameters.families().items()
        ]
        self.newest = [(0.0, 0.0)] * len(self.fits)
        """Time [s] and change of speed [m/s] of the newest node of the last step of each fit."""
        self._turn, self._stepped_at = 0, time + _FIRST_STEP
        self._mu_floor = radius_deviation(vehicle)
        self._silent_until = np.full((self._wheels, 1), -inf)
        self.road = self._new_road(time, EARLIEST_VALID)

    def _new_road(self, began_at: float, earliest_valid: float) -> Road:
        count = len(self.fits)
        return Road(began_at, earliest_valid, [inf] * count, [_STEPS_BACK] * count)

    def car_speed(self) -> float:
        """Return the speed of the car at the newest sample, by the accelerometer [m/s]."""
        return self.start.speed + (float(self.samples.speed_change[-1]) - self.start.speed_change)

    def make_room(self) -> None:
        """Let the oldest samples leave where the window is full."""
        capacity = self.road.astray.capacity(CAPACITY)
        if self.samples.count >= capacity:
            self._fold(((self.samples.count - capacity) // _FOLDED + 1) * _FOLDED)

    def move(self, time: float) -> bool:
        """Move the fit whose turn it is, where one is due at `time` [s]; return whether another road was found."""
        on_its_way = any(fit.promise > _PROMISE for fit in self.fits)
        if time - self._stepped_at < _STEP_INTERVAL * self._wheels * (0.5 if on_its_way else 1.0):
            return False
        changed = self._step(time)
        while self.road.peak is None and 0 < self._turn < len(self.fits):  # the first answer needs all families
            changed |= self._step(time)
        return changed

    def _fold(self, number: int) -> None:
        """Let the oldest `number` samples leave the window."""
        nodes, astray = self._nodes(), self.road.astray
        memory = exp(-float(nodes.time[number] - nodes.time[0]) / _MEMORY)
        for fit in self.fits:
            if astray.forgets:
                fit.forget(nodes, number)
            else:
                fit.fold(self.samples, nodes, self.start, number, memory)
        astray.forgot = astray.forgot or astray.forgets
        self.samples.drop_oldest(number)

    def _nodes(self) -> Nodes:
        is_mean = self._p.wheel_speed_is_interval_mean
        nodes = node_signals(self.car, self.samples, self.start, self._wheel_stddev, is_mean)
        if not (nodes.time[0] < self._silent_until).any():
            return nodes
        return replace(nodes, turning=nodes.turning & (nodes.time >= self._silent_until))

    def _step(self, time: float) -> bool:
        """Move the fit whose turn it is; return whether another road was found."""
        which = self._turn % len(self.fits)
        self._turn += 1
        self._stepped_at = time
        fit, road = self.fits[which], self.road
        evidence = self._log_evidence()
        best = int(np.argmax(evidence))
        arrived = fit.promise < _PROMISE and fit.steps >= road.may_go_back[which]
        if arrived and evidence[which] < evidence[best] - _ASTRAY:
            fit.begin_at(self.fits[best])
            road.may_go_back[which] = _LONGER * max(fit.steps, _STEPS_BACK)
        nodes = self._nodes()
        # The torque of the newest nodes has not been measured yet where pressures come late.
        known = self.samples.time[-1] - max(float(fit.unknowns[Unknown.PRESSURE_DELAY]), 0.0) - self.start.time
        keep = int(np.searchsorted(nodes.time + 0.5 * nodes.interval, known + _SAME_TIME))
        if keep < 5:
            self._turn = 0
            return False
        try:
            road.moves[which] = fit.step(self.samples, nodes.subset(slice(0, keep)), self.start)
        except np.linalg.LinAlgError:
            fit.reset()
            return False
        changed = all(each.steps for each in self.fits) and self._look(time, fit, nodes, keep)
        newest = keep - 1
        self.newest[which] = (
            float(nodes.time[newest]) + self.start.time,
            float(nodes.speed_change[newest]) + self.start.speed_change,
        )
        return changed

    def _look(self, time: float, fit: CurveFit, nodes: Nodes, keep: int) -> bool:
        """Look where the peak is after a step of `fit` with the first `keep` nodes; whether on another road."""
        fits, road = self.fits, self.road
        road.astray.stepped(time, fits, self.car, nodes)
        found = [each.unknowns for each in fits], [each.covariance for each in fits]
        evidence = self._log_evidence()
        road.peak = mixture(*found, evidence, self._mu_floor, True, gone_astray=road.astray.forgot)
        road.unresolved = 0.0
        road.passing.update(fit, road.peak, nodes.subset(slice(0, keep)))
        if not road.passing.in_window:
            road.peak = mixture(*found, evidence, self._mu_floor, False, [each.unsettled for each in fits])
        elif len(fits) > 1:  # what is between the samples is known where the formula is
            road.unresolved = unresolved(fit.tyres.size, exp(road.peak.log_lambda_max))
        return road.passing.seen and self._watch_road(fit, nodes.subset(slice(0, keep)), road.astray.calm(time))

    def _log_evidence(self) -> list[float]:
        """Log evidence of the fits for the nodes that all of them have seen."""
        common = min(fit.newest for fit in self.fits)
        return [fit.log_evidence_until(common) for fit in self.fits]

    def _watch_road(self, fit: CurveFit, nodes: Nodes, calm: bool) -> bool:
        """Look for another road, and for two of them where the fits have not gone astray (`calm`)."""
        road = self.road
        delay = float(fit.unknowns[Unknown.PRESSURE_DELAY])
        torque, rate = delayed(self.samples, nodes, self.start, delay)
        mu_max = exp(float(fit.unknowns[Unknown.LOG_MU_MAX]))
        shown = shows_friction(fit.tyres, mu_max)
        used, fitted, comparable = used_and_fitted(self.car, nodes, fit.moved, fit.tyres, torque, fit.unknowns)
        if road.peak is not None and road.peak.log_mu_stddev < _KNOWN_MU:
            told = told_of_roads(self.car, fit.moved, fitted, mu_max, rate) & (nodes.time >= self._silent_until)
            told &= shown
            new_road = axle_on_new_road(self.car, nodes.time, used, fitted, told)
            if new_road is not None:
                self._begin_anew(nodes, new_road, used * told, fit)
                # What led the fits astray is that of the car, and may lead them there again.
                self.road.astray.forgot = not calm
                return True
        if not (calm or road.watch.changes):  # another road may be what led the fits astray
            return False
        comparable &= shown
        used, fitted = used * comparable, fitted * comparable
        misfit = misfit_at_peak(used, fitted, mu_max, nodes.time)
        sides = side_deviations(fit.moved)
        road.two_roads = road.watch.update(used, fitted, self.car.left, nodes.time, misfit, sides)
        if not isnan(misfit):
            road.misfit = misfit
        if not road.watch.changed:
            return False
        every, since = np.ones(self._wheels, dtype=np.bool_), float(nodes.time[-1]) - NEWEST
        self._begin_anew(nodes, NewRoad(every, since - LASTING, since), used, fit)
        return True

    def _begin_anew(self, nodes: Nodes, found: NewRoad, used: Array, fit: CurveFit) -> None:
        """Begin the curve anew on another road, from where it is seen; what is known of the car stays.

        `used`: friction that the wheels have used, zero where it tells nothing, shape (W, n).
        """
        mu = friction_there(found, nodes.time, used)
        known = int(np.searchsorted(nodes.time, found.known_until, side="right"))
        if known >= 2:
            self._fold(known)
        self._silent_until = silenced(
            self._silent_until, found, self.car, self._vehicle.wheelbase, nodes.time, fit.moved.speed
        )
        for each in self.fits:
            each.begin_anew(mu)
        self._turn = 0
        self.road = self._new_road(float(nodes.time[-1]) + self.start.time, _EARLIEST_ANEW)
