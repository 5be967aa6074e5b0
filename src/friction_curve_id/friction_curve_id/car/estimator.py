"""The friction curve of a car that is not known exactly, sample by sample.

One curve is fitted for all wheels of the car: that they are on the same road is an assumption. While the car brakes,
each family of curves takes one Gauss-Newton step in turn, with four wheels every 18 ms at most whatever the rate, 9 ms
while a fit is far from where it goes; in between, the present slip is followed with the last fit. What leaves the
window of the newest second stays as a quadratic, which fades. While no brake acts, wheels that spin under the engine
tell of mu_max (traction.py).
"""

from dataclasses import replace
from math import exp, hypot, inf, isfinite, isnan, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.astray import Astray
from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_model import CarConstants, Nodes
from friction_curve_id.car.car_sample import CarGate, CarSample, Checked
from friction_curve_id.car.combined_slip import shows_friction
from friction_curve_id.car.curve_family import Family, burckhardt_k, curve_values
from friction_curve_id.car.evidence import (
    UNRESOLVED_HEIGHT,
    Peak,
    doubt,
    mixture,
    reaching_up,
    unresolved,
)
from friction_curve_id.car.fit import LOAD_VARIATIONS, CurveFit
from friction_curve_id.car.gain_over_mass import GainOverMassLearner
from friction_curve_id.car.lateral_motion import LateralMotion
from friction_curve_id.car.new_road import NewRoad, axle_on_new_road, friction_there, silenced, told_of_roads
from friction_curve_id.car.node_signals import Start, delayed, node_signals
from friction_curve_id.car.one_road import LASTING, NEWEST, RoadWatch, misfit_at_peak, used_and_fitted
from friction_curve_id.car.parameters import CarEstimatorParameters
from friction_curve_id.car.passing import Passing
from friction_curve_id.car.present_slip import present_slip
from friction_curve_id.car.prior import SLIP_OFFSET_STDDEV, car_prior, radius_deviation
from friction_curve_id.car.traction import Traction
from friction_curve_id.car.tyre_deviations import LAMBDA_MAX, mu_max_deviations, side_deviations
from friction_curve_id.car.unknowns import Unknown
from friction_curve_id.interface import UNKNOWN_THETA, CurveEstimate, Refusal, RestartCause
from sensor_monitor.signal_noise import white_noise
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ACROSS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]
Answers = tuple[CurveEstimate | Refusal, ...]

_INTERVAL = 0.0045
"""Least time between two samples of the window [s]; faster ones are averaged."""
_STEP_INTERVAL = 0.0045
"""Least time between two Gauss-Newton steps for each wheel of the car [s]: what they cost goes with the wheels."""
_PROMISE = 20.0
"""Gain in ln of the likelihood that a step promises from which on steps come twice as often: the fit is on its way."""
_BEFORE = 0.4
"""Time before the braking that is kept [s]."""
_LEAST_BEFORE = 0.1
_LIFT = 0.15
"""The throttle is taken as closed for this time before the brakes act [s]."""
_CAPACITY, _FOLDED = 260, 40
"""Most samples of the window, and how many leave it at a time."""
_MEMORY = 3.0
"""Time with which what has left the window fades [s]."""
_FIRST_STEP = 0.03
"""Time of braking before the first step [s]: a fast rise uses half of the friction after 0.08 s."""
_BRAKES, _RELEASED = 0.2, 0.15
"""Deceleration by the brakes at which a braking begins, and ends [m/s^2]."""
_RELEASE_TIME = 0.15
_COMES_BACK, _FAR_BEHIND = 0.6, 0.8
"""A braking goes on for so long without brakes [s] while a wheel is slower than this share of the car."""
_SAME_TIME = 1e-6
"""Times are equal within this [s]."""
_LARGEST_STDDEV = 0.25
"""Largest deviation of lambda_max that is valid, and of a mu_max that is known alone, as a share [-]."""
_EARLIEST_VALID = 0.1
_EARLIEST_ANEW = 0.5
"""Time of a braking, or on another road within it, before which nothing is valid [s]. There the axles come one after
the other, and most of what their wheels do first is too fast to tell."""
_ASTRAY, _STEPS_BACK = 50.0, 5
"""A fit that arrives where its log evidence is that much lower is in a minimum of its own; steps that it has for it."""
_LONGER = 2
"""What a fit that has gone back has to arrive once more, in its steps until then: its formula may be the wrong one."""
_KNOWN_MU = 0.1
"""Relative deviation of mu_max below which another road is told from the present one."""
_MOST_UNMEASURED = 0.03
"""Share of the friction along the wheels that a curve may take where nothing measures the motion across."""
_LEAST_WHEEL_STDDEV = 0.01
"""Least noise of a wheel speed [rad/s]."""
_BETWEEN_ROADS = 1.0
"""Deviation of ln lambda_max and ln mu_max while the newest friction is that of another road."""
_SETTLED = 0.1
"""Step of ln lambda_max and ln mu_max below which a fit has settled."""


class CarEstimator:
    """Estimator of the curve of all wheels of a car."""

    def __init__(self, vehicle: Vehicle, parameters: CarEstimatorParameters = CarEstimatorParameters()) -> None:
        """Take the car with its deviations."""
        self._vehicle, self._p = vehicle, parameters
        self.learner = GainOverMassLearner(vehicle)
        """What is learned from braking to braking."""
        self._gate = CarGate(vehicle, parameters.max_gap)
        self._radii = np.array(vehicle.radii)
        self._gain = np.array([wheel.brake_gain for wheel in vehicle.wheels])
        self._cause = RestartCause.NONE
        self._lateral = LateralMotion(vehicle)
        self._traction = Traction(vehicle, parameters.families(), parameters.minimum_speed)
        self._begin_again(())

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._gate.reset()
        self.learner.reset()
        self._traction.reset()
        self._cause = RestartCause.REQUEST
        self._begin_again(())

    def update(self, sample: CarSample) -> Answers:
        """Take the next sample and answer for each wheel; never raises on bad data."""
        checked = self._gate.admit(sample)
        count = len(self._vehicle.wheels)
        if isinstance(checked, Refusal):
            return (checked,) * count
        self.learner.update(checked)
        spinning = self._traction.update(checked, self._braking or self._unknown_start)
        present = tuple(int(each) for each in np.flatnonzero(np.isfinite(checked.wheel_speed)))
        if checked.after_gap:
            if self._braking:
                self._cause = RestartCause.GAP
            self._begin_again(present)
        elif present != self._present:
            if self._braking and set(self._present) - set(present):
                missing = ", ".join(self._vehicle.wheel_names[each] for each in set(self._present) - set(present))
                return (Refusal(Reason.BAD_INPUT, f"wheel speed or brake pressure of {missing} is missing"),) * count
            if not self._braking:
                self._begin_again(present)
        if not self._present:
            return (Refusal(Reason.BAD_INPUT, "no wheel has both a speed and a brake pressure"),) * count
        if self._braking and self._with_accelerometer and not isfinite(checked.acceleration):
            return (Refusal(Reason.NO_ACCELERATION, "acceleration is missing: check imu/data"),) * count
        if self._braking and self._lateral_at is not None and not isfinite(checked.yaw_rate):
            return (
                Refusal(Reason.NO_ACCELERATION, "yaw rate or lateral acceleration is missing: check imu/data"),
            ) * count
        answer = self._take(checked)
        if isinstance(answer, Refusal):
            otherwise, told = answer, zip(self._traction.driven, spinning, strict=False)
        else:
            otherwise = Refusal(Reason.BAD_INPUT, "wheel speed or brake pressure is missing")
            told = zip(self._present, answer, strict=True)
        by_wheel: list[CurveEstimate | Refusal] = [otherwise] * count
        for each, estimate in told:
            by_wheel[each] = estimate
        return tuple(by_wheel)

    def _begin_again(self, present: tuple[int, ...]) -> None:
        """Forget the samples; go on with these wheels."""
        self._present = present
        self._braking = False
        self._fits: list[CurveFit] = []
        self._with_accelerometer = True
        self._unknown_start = False
        self._released_at = inf
        index = list(present)
        self._index = index
        self._samples = BrakingSamples(max(len(index), 1), _CAPACITY)
        self._gathered_time = 0.0
        self._gathered_turn = np.zeros(len(index))
        self._gained = 0.0
        self._last: Checked | None = None
        self._lateral.reset()
        self._lateral_at: float | None = None
        """Speed at the begin of the braking [m/s]; None where the motion across the car is not measured."""
        if present:
            self._car = CarConstants(self._vehicle, present)
            self._per_torque = 1.0 / (self._radii[index] * self._car.mass * self._car.carried_share)

    def _take(self, sample: Checked) -> list[CurveEstimate] | Refusal:
        """Take a sample of the present wheels."""
        index, last = self._index, self._last
        speed, torque = sample.wheel_speed[index], sample.brake_pressure[index] * self._gain[index]
        braking_by = float(self._per_torque @ torque)
        if not self._braking:
            self._with_accelerometer = isfinite(sample.acceleration)
        acceleration = sample.acceleration
        interval = 0.0 if last is None else sample.time - last.time
        if not self._with_accelerometer:
            growth, mean_torque = np.zeros_like(speed), torque
            if last is not None:
                growth = (speed - last.wheel_speed[index]) / interval
                mean_torque = 0.5 * (torque + last.brake_pressure[index] * self._gain[index])
            acceleration = -float(self._per_torque @ (self._car.inertia[:, 0] * growth + mean_torque))
        before = acceleration if last is None or not isfinite(last.acceleration) else last.acceleration
        self._gained += interval * 0.5 * (acceleration + before if self._with_accelerometer else 2.0 * acceleration)
        turned = bool(self._car.partner) and self._with_accelerometer and isfinite(sample.yaw_rate)
        if turned:
            self._gained += interval * sample.yaw_rate * self._lateral.sideways
        self._gathered_time += interval
        self._gathered_turn += interval * speed
        self._last = sample._replace(acceleration=acceleration)
        complete = self._samples.count == 0 or self._gathered_time >= _INTERVAL
        if complete:
            mean = speed
            if self._p.wheel_speed_is_interval_mean and self._gathered_time > 0.0:
                mean = self._gathered_turn / self._gathered_time
            before_it = float(self._samples.time[-1]) if self._samples.count else sample.time
            self._keep(sample.time, mean, torque, acceleration)
            if turned:
                self._turn_with(sample, sample.time - before_it, speed)
            self._gathered_time, self._gained = 0.0, 0.0
            self._gathered_turn = np.zeros(len(index))
        if float((self._radii[index] * speed).max()) < self._p.minimum_speed and not self._braking:
            return Refusal(Reason.LOW_SPEED, f"waiting for a speed above {self._p.minimum_speed} m/s")
        self._watch_brakes(sample.time, braking_by, speed)
        if not self._braking:
            if self._unknown_start:
                return Refusal(Reason.NO_EXCITATION, "waiting for the next braking: the speed before this is unknown")
            return Refusal(Reason.NO_EXCITATION, "waiting for a braking")
        on_its_way = any(fit.promise > _PROMISE for fit in self._fits)
        if complete and sample.time - self._stepped_at >= _STEP_INTERVAL * len(index) * (0.5 if on_its_way else 1.0):
            self._step(sample.time)
            while self._peak is None and 0 < self._turn < len(self._fits):  # the first answer needs all families
                self._step(sample.time)
        return self._answer(sample.time, speed)

    def _keep(self, time: float, speed: Array, torque: Array, acceleration: float) -> None:
        samples = self._samples
        if self._braking:
            capacity = self._astray.capacity(_CAPACITY)
            if samples.count >= capacity:
                self._fold(((samples.count - capacity) // _FOLDED + 1) * _FOLDED)
        else:
            while (samples.count > 1 and time - samples.time[1] > _BEFORE) or samples.count == _CAPACITY:
                samples.drop_oldest(max(int(np.searchsorted(samples.time, time - _BEFORE)) - 1, 1))
        samples.append(time, speed, torque, acceleration, self._gained, self._braking)

    def _turn_with(self, sample: Checked, interval: float, speed: Array) -> None:
        """Follow the motion across the car, and add it to the newest sample of the window."""
        car_speed = float((self._radii[self._index] * speed).mean())
        if self._braking:
            moved = float(self._samples.speed_change[-1]) - self._start.speed_change
            car_speed = max(self._start.speed + moved, 1.0)
        self._lateral.update(interval, car_speed, sample.yaw_rate, sample.leftward, self._braking)
        self._samples.turn(sample.yaw_rate, sample.leftward, self._lateral.turned, self._lateral.rolled)

    def _watch_brakes(self, time: float, braking_by: float, speed: Array) -> None:
        """Begin and end brakings."""
        if not self._braking and not self._unknown_start:
            if braking_by > _BRAKES:
                if time - self._samples.time[0] >= _LEAST_BEFORE and self._samples.count >= 5:
                    self._begin_braking(time)
                else:
                    self._unknown_start = True
            return
        if braking_by > _RELEASED:
            self._released_at = inf
        elif self._released_at == inf:
            self._released_at = time
        released_for = time - self._released_at
        comes_back = self._braking and released_for < _COMES_BACK and self._slips_far(speed)
        if released_for > _RELEASE_TIME and not comes_back:
            self._begin_again(self._present)

    def _slips_far(self, speed: Array) -> bool:
        """Whether a wheel is far behind the car: an anti-lock system has opened its brake, not the driver."""
        moved = float(self._samples.speed_change[-1]) - self._start.speed_change
        return float((self._radii[self._index] * speed).min()) < _FAR_BEHIND * (self._start.speed + moved)

    def _begin_braking(self, time: float) -> None:
        samples, p = self._samples, self._p
        samples.close_throttle(time - _LIFT)
        self._braking, self._began_at, self._stepped_at, self._turn = True, time, time + _FIRST_STEP, 0
        few = min(3, samples.count)
        # A driven wheel slips under its engine before the brakes act: on soft snow by a fiftieth of the speed.
        free = self._car.driven[:, 0] == 0.0
        if not free.any():
            free[:] = True
        rolling = float((self._car.radius[free, 0] * samples.wheel_speed[free, :few].mean(axis=1)).mean())
        at_rest = float(samples.acceleration[: max(samples.count // 4, 1)].mean())
        self._start = Start(
            float(samples.time[0]), rolling, at_rest, float(samples.speed_change[0]), float(samples.sideways[0])
        )
        self._wheel_stddev = np.maximum(white_noise(samples.wheel_speed), _LEAST_WHEEL_STDDEV)
        self._lateral_at = None
        if self._car.partner and self._with_accelerometer and self._last and isfinite(self._last.yaw_rate):
            self._lateral_at = rolling
        self._lateral.begin_braking()
        if self._lateral_at is None:
            samples.straighten()
        balanced = self._with_accelerometer and len(self._present) == len(self._vehicle.wheels)
        self._fits = [
            CurveFit(
                self._car,
                car_prior(
                    self._vehicle,
                    self._present,
                    shape,
                    p.slope_stddev,
                    self._with_accelerometer,
                    self._lateral_at,
                    self._lateral.sideways - self._lateral.turned + float(samples.sideways[0]),
                ),
                family,
                p.torque_stddev,
                balanced,
            )
            for family, shape in p.families().items()
        ]
        self._families = tuple(p.families())
        self._newest = [(0.0, 0.0)] * len(self._fits)  # time and change of speed of the newest node of the last step
        self._mu_floor = radius_deviation(self._vehicle)
        self._earliest_valid = _EARLIEST_VALID
        self._silent_until = np.full((len(self._present), 1), -inf)
        self._begin_road()

    def _begin_road(self) -> None:
        """Nothing is known of the road."""
        self._peak: Peak | None = None
        self._astray = Astray()
        self._road_watch, self._two_roads = RoadWatch(), ""
        self._misfit = self._unresolved = 0.0
        self._passing = Passing()
        self._move = [inf] * len(self._fits)
        self._may_go_back = [_STEPS_BACK] * len(self._fits)

    def _fold(self, number: int) -> None:
        """Let the oldest `number` samples leave the window."""
        nodes = self._nodes()
        memory = exp(-float(nodes.time[number] - nodes.time[0]) / _MEMORY)
        for fit in self._fits:
            if self._astray.forgets:
                fit.forget(nodes, number)
            else:
                fit.fold(self._samples, nodes, self._start, number, memory)
        self._astray.forgot = self._astray.forgot or self._astray.forgets
        self._samples.drop_oldest(number)

    def _nodes(self) -> Nodes:
        is_mean = self._p.wheel_speed_is_interval_mean
        nodes = node_signals(self._car, self._samples, self._start, self._wheel_stddev, is_mean)
        if not (nodes.time[0] < self._silent_until).any():
            return nodes
        return replace(nodes, turning=nodes.turning & (nodes.time >= self._silent_until))

    def _step(self, time: float) -> None:
        """Move the fit whose turn it is."""
        which = self._turn % len(self._fits)
        self._turn += 1
        self._stepped_at = time
        fit = self._fits[which]
        evidence = self._log_evidence()
        best = int(np.argmax(evidence))
        arrived = fit.promise < _PROMISE and fit.steps >= self._may_go_back[which]
        if arrived and evidence[which] < evidence[best] - _ASTRAY:
            fit.begin_at(self._fits[best])
            self._may_go_back[which] = _LONGER * max(fit.steps, _STEPS_BACK)
        nodes = self._nodes()
        # The torque of the newest nodes has not been measured yet where pressures come late.
        known = self._samples.time[-1] - max(float(fit.unknowns[Unknown.PRESSURE_DELAY]), 0.0) - self._start.time
        keep = int(np.searchsorted(nodes.time + 0.5 * nodes.interval, known + _SAME_TIME))
        if keep < 5:
            self._turn = 0
            return
        try:
            self._move[which] = fit.step(self._samples, nodes.subset(slice(0, keep)), self._start)
        except np.linalg.LinAlgError:
            fit.reset()
            return
        if all(each.steps for each in self._fits):
            fits = self._fits
            self._astray.stepped(time, fits, self._car, nodes)
            found = [each.unknowns for each in fits], [each.covariance for each in fits]
            evidence = self._log_evidence()
            self._peak = mixture(*found, evidence, self._mu_floor, True, gone_astray=self._astray.forgot)
            self._unresolved = 0.0
            self._passing.update(fit, self._peak, nodes.subset(slice(0, keep)))
            if not self._passing.in_window:
                self._peak = mixture(*found, evidence, self._mu_floor, False, [each.unsettled for each in fits])
            elif len(fits) > 1:  # what is between the samples is known where the formula is
                self._unresolved = unresolved(fit.tyres.size, exp(self._peak.log_lambda_max))
            if self._passing.seen:
                self._watch_road(fit, nodes.subset(slice(0, keep)), self._astray.calm(time))
        newest = keep - 1
        self._newest[which] = (
            float(nodes.time[newest]) + self._start.time,
            float(nodes.speed_change[newest]) + self._start.speed_change,
        )

    def _log_evidence(self) -> list[float]:
        """Log evidence of the fits for the nodes that all of them have seen."""
        common = min(fit.newest for fit in self._fits)
        return [fit.log_evidence_until(common) for fit in self._fits]

    def _watch_road(self, fit: CurveFit, nodes: Nodes, calm: bool) -> None:
        """Look for another road, and for two of them where the fits have not gone astray (`calm`)."""
        delay = float(fit.unknowns[Unknown.PRESSURE_DELAY])
        torque, rate = delayed(self._samples, nodes, self._start, delay)
        mu_max = exp(float(fit.unknowns[Unknown.LOG_MU_MAX]))
        shown = shows_friction(fit.tyres, mu_max)
        used, fitted, comparable = used_and_fitted(self._car, nodes, fit.moved, fit.tyres, torque, fit.unknowns)
        if self._peak is not None and self._peak.log_mu_stddev < _KNOWN_MU:
            told = told_of_roads(self._car, fit.moved, fitted, mu_max, rate) & (nodes.time >= self._silent_until)
            told &= shown
            new_road = axle_on_new_road(self._car, nodes.time, used, fitted, told)
            if new_road is not None:
                self._begin_anew(nodes, new_road, used * told, fit)
                # What led the fits astray is that of the car, and may lead them there again.
                self._astray.forgot = not calm
                return
        if not (calm or self._road_watch.changes):  # another road may be what led the fits astray
            return
        comparable &= shown
        used, fitted = used * comparable, fitted * comparable
        misfit = misfit_at_peak(used, fitted, mu_max, nodes.time)
        sides = side_deviations(fit.moved)
        self._two_roads = self._road_watch.update(used, fitted, self._car.left, nodes.time, misfit, sides)
        if not isnan(misfit):
            self._misfit = misfit
        if self._road_watch.changed:
            every, since = np.ones(len(self._present), dtype=np.bool_), float(nodes.time[-1]) - NEWEST
            self._begin_anew(nodes, NewRoad(every, since - LASTING, since), used, fit)

    def _begin_anew(self, nodes: Nodes, road: NewRoad, used: Array, fit: CurveFit) -> None:
        """Begin the curve anew on another road, from where it is seen; what is known of the car stays.

        `used`: friction that the wheels have used, zero where it tells nothing, shape (W, n).
        """
        mu = friction_there(road, nodes.time, used)
        known = int(np.searchsorted(nodes.time, road.known_until, side="right"))
        if known >= 2:
            self._fold(known)
        self._silent_until = silenced(
            self._silent_until, road, self._car, self._vehicle.wheelbase, nodes.time, fit.moved.speed
        )
        for each in self._fits:
            each.begin_anew(mu)
        self._begin_road()
        self._began_at, self._turn = float(nodes.time[-1]) + self._start.time, 0
        self._earliest_valid = _EARLIEST_ANEW
        self._cause = RestartCause.SURFACE

    def _answer(self, time: float, speed: Array) -> list[CurveEstimate]:
        cause, self._cause = self._cause, RestartCause.NONE
        count = self._samples.count
        peak = self._peak
        if peak is None:
            text = "waiting for the first fit of this braking"
            return [CurveEstimate(count, nan, restart_cause=cause, text=text)] * len(self._index)
        slips, slip_stddevs, beyond = self._slips(time, speed, peak)
        reason, text = self._reason(time, peak)
        passed = reason is Reason.OK
        if passed:
            reason, text = self._reason_of_lambda_max(peak)
        self._astray.was_valid = self._astray.was_valid or reason is Reason.OK
        lambda_max, mu_max = exp(peak.log_lambda_max), exp(peak.log_mu_max)
        best = int(np.argmax(peak.weights))
        surprised = self._astray.unexplained or bool(self._two_roads)
        u = self._fits[best].unknowns
        shape = (float(u[Unknown.SHAPE_1]), float(u[Unknown.SHAPE_2]))
        curve = curve_values(self._families[best], peak.log_lambda_max, shape, slips / lambda_max)
        mu, slope = mu_max * curve.value, mu_max / lambda_max * curve.slope
        of_lambda, of_mu = 0.0, np.zeros(len(self._index))
        between = _BETWEEN_ROADS if self._road_watch.changes else 0.0
        if len(self._fits) > 1:  # with one formula given, the tyres are given to be of it
            of_lambda, of_mu = LAMBDA_MAX, mu_max_deviations(self._fits[best].moved, self._fits[best].tyres)
        log_mu_stddev = hypot(peak.log_mu_stddev, self._misfit, UNRESOLVED_HEIGHT * self._unresolved, between)
        mu_stddevs = [reaching_up(hypot(log_mu_stddev, float(each))) for each in of_mu]
        theta = UNKNOWN_THETA
        if self._families[best] is Family.BURCKHARDT:
            theta = burckhardt_theta(peak, shape[0])
        return [
            CurveEstimate(
                count,
                float(slips[each]),
                lambda_max,
                mu_max,
                lambda_max * hypot(peak.log_lambda_stddev, self._unresolved, of_lambda, between),
                mu_max * mu_stddevs[each],
                theta,
                mu=float(mu[each]),
                slope=float(slope[each]),
                probability_beyond_peak=nan if surprised else beyond[each],
                restart_cause=cause,
                reason=reason,
                text=text,
                slip_stddev=float(slip_stddevs[each]),
                mu_max_known=passed and mu_stddevs[each] < _LARGEST_STDDEV,
            )
            for each in range(len(self._index))
        ]

    def _slips(self, time: float, speed: Array, peak: Peak) -> tuple[Array, Array, list[float]]:
        """Present slips with their deviations, and the probabilities that they are beyond the peak."""
        wheels = len(self._index)
        mean, square = np.zeros(wheels), np.zeros(wheels)
        beyond = [0.0] * wheels
        seen = self._passing.in_window
        factor, floor = doubt(seen, len(self._fits) == 1)
        if not seen:  # a formula may be as wrong as the two of them differ
            log_peaks = [float(fit.unknowns[Unknown.LOG_LAMBDA_MAX]) for fit in self._fits]
            floor = hypot(floor, max(log_peaks) - min(log_peaks))
        changed = float(self._samples.speed_change[-1]) + self._gained
        yaw_rate = float(self._samples.yaw_rate[-1])
        for weight, fit, (since, changed_then) in zip(peak.weights, self._fits, self._newest, strict=True):
            slip, variance, probability = present_slip(
                self._car, fit, time - since, changed - changed_then, speed, yaw_rate, factor, floor
            )
            mean += weight * slip
            square += weight * (slip**2 + variance)
            for each in range(wheels):
                beyond[each] += weight * probability[each]
        # a sum of weights may be more than 1 in its last bit
        return mean, np.sqrt(np.maximum(square - mean**2, 0.0)), [min(each, 1.0) for each in beyond]

    def _reason(self, time: float, peak: Peak) -> tuple[Reason, str]:
        """Return why neither lambda_max nor mu_max may be used, OK where one of them may."""
        since = time - self._began_at
        if since < _EARLIEST_VALID and self._earliest_valid == _EARLIEST_VALID:
            return Reason.NOT_READY, f"waiting for {_EARLIEST_VALID} s of braking"
        if self._in_unmeasured_curve(peak):
            return (
                Reason.UNCERTAIN,
                "in a curve: yaw rate or lateral acceleration is missing, check imu/data",
            )
        if not self._passing.begun:
            return Reason.PEAK_NOT_PASSED, "waiting for a wheel to pass the peak"
        if not (self._passing.seen and self._passing.long_ago(time - self._start.time)):
            return Reason.PEAK_NOT_PASSED, "a wheel has just passed the peak: waiting for 0.1 s beyond it"
        best = int(np.argmax(peak.weights))
        if since < self._earliest_valid:
            return Reason.UNCERTAIN, f"waiting for {self._earliest_valid} s on the new road"
        if self._astray.unexplained or not self._astray.calm(time):
            return Reason.UNCERTAIN, "the car does not move as its vehicle file says: run vehicle_doctor"
        if self._lateral_at is not None and self._lateral.slides:
            return Reason.UNCERTAIN, "the car slides sideways"
        if self._two_roads:
            return Reason.UNCERTAIN, self._two_roads
        if self._move[best] > _SETTLED:
            return Reason.UNCERTAIN, "waiting for the fit to settle"
        if self._fits[best].load_variation == LOAD_VARIATIONS.size - 1:
            return (
                Reason.UNCERTAIN,
                "the wheels follow no common curve: run vehicle_doctor",
            )
        return Reason.OK, ""

    def _in_unmeasured_curve(self, peak: Peak) -> bool:
        """Whether the wheels show a curve that takes much of the friction, and nothing measures it."""
        fit = self._fits[int(np.argmax(peak.weights))]
        if self._lateral_at is not None or fit.steps == 0:
            return False
        turned = float(fit.unknowns[Unknown.CURVE] + fit.unknowns[Unknown.CURVE_RATE] * fit.newest)
        stddev = hypot(sqrt(fit.covariance[Unknown.CURVE, Unknown.CURVE]), SLIP_OFFSET_STDDEV)
        speed = float(fit.moved.speed[-1])
        leftward = turned * speed**2 / self._car.half_track
        across = leftward / (ACROSS * GRAVITY * exp(peak.log_mu_max))
        return abs(turned) > 2.0 * stddev and 0.5 * across**2 > _MOST_UNMEASURED

    def _reason_of_lambda_max(self, peak: Peak) -> tuple[Reason, str]:
        stddev = hypot(peak.log_lambda_stddev, self._unresolved)
        if stddev > _LARGEST_STDDEV:
            return Reason.UNCERTAIN, f"waiting for slips around the peak: lambda_max has a deviation of {stddev:.0%}"
        return Reason.OK, ""


def burckhardt_theta(peak: Peak, u: float) -> Array:
    """Parameters of (2.13) of a Burckhardt curve with this peak, shape (3,)."""
    k = burckhardt_k(peak.log_lambda_max, u)
    lambda_max = exp(peak.log_lambda_max)
    theta_1 = exp(peak.log_mu_max) / (1.0 - exp(-k) - k * exp(-k))
    return np.array([theta_1, k / lambda_max, theta_1 * k * exp(-k) / lambda_max])
