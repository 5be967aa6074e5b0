"""Speed of the car: a Kalman filter driven by the accelerometer, with its errors and the slip of rolling wheels.

    v_dot = (a_m - b) (1 - k),    b_dot = n_b,    k_dot = 0,    c_dot = (c_0 - c) / T + n_c

a_m is the measured acceleration, n_a its noise, b its offset: sensor bias and road slope together (g sin(slope)), which
a speed measurement separates from a_m and nothing else can. k is the error of its scale, with that of the body's pitch.
c is the slip of rolling wheels per deceleration of the car: such wheels measure v (1 + c v_dot). An accelerometer is
low-passed before it is sampled, so a sample is taken to hold for the whole interval it ends. Where it reads what was
some time tau = tau_0 + e ago, v grows by tau times each change of a_m besides; tau_0 is stated. e is not estimated, as
slip that grows with the deceleration looks the same, and moves no estimate: what an e would have done to the state is
followed, as corrections leave it, and is in the variance (a consider parameter that is left out of the gains). Without
an accelerometer a_m is 0, b is minus the acceleration of the car, and n_b is as strong as the changes of acceleration
of a braking car.

While nothing observes the offset, the road may change its slope unseen. What that may have done to speed and offset is
kept apart, in a second covariance (unseen_road.py), and so is what k has done to the speed; the sum of all is the
uncertainty. `believe` corrects as if the road had kept its slope and leaves the unseen part alone. Every other
correction takes all together.

A measurement z of the speed at an earlier time t_m is used as it is: v(t_m) = v - (A - b (t - t_m)) (1 - k), where A
is the integral of a_m from t_m to t. So a late sensor delays nothing and blurs nothing.
"""

from collections import deque
from dataclasses import dataclass
from math import exp, isfinite, sqrt
from typing import Final

from friction_parameters.parameter import parameter
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.tuning import SpeedFilterTuning
from wheel_slip.unseen_road import UnseenRoad

_HISTORY: Final = 1 * NANOSECONDS
"""How far back [ns] a measurement can be used."""
_FIRST_SPEED_VARIANCE: Final = 1e6
"""Variance of an unknown speed [m^2/s^2]."""
_SURPRISING: Final = 3.0
"""Deviations of a gap that shows a slope."""
_HALFWAY: Final = 2.0
"""How much steeper a slope is that began halfway to where it was seen."""
_GAP: Final = 0.1
"""Longer steps between samples are gaps [s]."""
_AVERAGED: Final = 0.75
"""Time over which the readings are averaged for what an e does, as a share of the deviation of e."""
_ALL: Final = range(4)
_OTHERS: Final = range(1, 4)


@dataclass(frozen=True)
class AccelerometerParameters:
    """Errors of the accelerometer."""

    stddev: float = parameter(0.1, "noise of an accelerometer sample", unit="m/s^2", minimum=1e-3, maximum=10.0)
    bias_stddev: float = parameter(
        0.4, "bias (road grade included) to expect before it is learned", unit="m/s^2", minimum=1e-3, maximum=10.0
    )


class SpeedFilter:
    """State (v, b, k, c) and its covariance, and what e has done to it."""

    def __init__(
        self,
        accelerometer: AccelerometerParameters = AccelerometerParameters(),
        tuning: SpeedFilterTuning = SpeedFilterTuning(),
        gain_stddev: float | None = None,
        delay: float = 0.0,
        delay_stddev: float | None = None,
    ) -> None:
        """Start with nothing known.

        Args:
            accelerometer: its noise and offset.
            tuning: of offset, gain and slip.
            gain_stddev: as in the tuning, where the car's is known.
            delay: age tau_0 of a reading of the accelerometer against the wheel speeds [s].
            delay_stddev: deviation of e [s], where the car's is known.
        """
        self._accelerometer = accelerometer
        self._parameters = p = tuning
        self._road = UnseenRoad(p.blind_offset_walk, p.slope_stddev, p.slope_length)
        self._delay = delay
        self._delay_variance = (tuning.delay_stddev if delay_stddev is None else delay_stddev) ** 2
        self._averaged = _AVERAGED * sqrt(self._delay_variance)
        self._gain_variance = (tuning.gain_stddev if gain_stddev is None else gain_stddev) ** 2
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        p = self._parameters
        self.speed = 0.0
        """Vehicle speed [m/s], forward positive."""
        self.offset = 0.0
        """Offset b [m/s^2]; minus the acceleration while there is no accelerometer."""
        self.gain = 0.0
        """Error k of the accelerometer's scale, as a share."""
        self.compliance = p.compliance
        """Slip c of rolling wheels per deceleration [s^2/m]."""
        self.surprise = 0.0
        """Last innovation over its standard deviation [-]."""
        self.by_wheels = 1.0
        """Share of an error that all radii have in common which the speed has: 1 from wheels alone, 0 from a sensor."""
        self._p = _diagonal(
            _FIRST_SPEED_VARIANCE, self._accelerometer.bias_stddev**2, self._gain_variance, p.compliance_stddev**2
        )
        self._by_age = [0.0] * len(_ALL)
        """Errors of the state by an e of 1 s."""
        self._road.clear()
        self._unseen_gain = 0.0
        """What a gain of 1 would have done to the speed unseen [m/s]."""
        self._measured: float | None = 0.0
        self._mean = 0.0
        """Mean of the last readings [m/s^2]: an e makes the integral wrong by as much of them as it lasts."""
        self._travelled = 0.0
        self._history: deque[tuple[int, float, float]] = deque()
        self._kept = (0.0, self._accelerometer.bias_stddev**2)

    @property
    def speed_variance(self) -> float:
        """[m^2/s^2]"""
        return self._p[0][0] + self._road.total[0] + self._by_gain() + self._by_delay()

    @property
    def offset_variance(self) -> float:
        """[m^2/s^4]"""
        return self._p[1][1] + self._road.total[2]

    @property
    def undoubted_offset_variance(self) -> float:
        """The same but for steps of the slope that wheels in a slide may have shown [m^2/s^4]."""
        return self._p[1][1] + self._road.passing_variance

    @property
    def steady_road_variance(self) -> float:
        """Variance of the speed, if the road has kept its slope [m^2/s^2]."""
        return self._p[0][0]

    @property
    def acceleration(self) -> float:
        """Acceleration of the car [m/s^2], forward positive."""
        return ((self._measured or 0.0) - self.offset) * self._scale

    @property
    def acceleration_variance(self) -> float:
        """[m^2/s^4]"""
        noise = self._accelerometer.stddev**2 if self._measured is not None else 0.0
        return self.offset_variance + noise + self._p[2][2] * self.acceleration**2

    @property
    def slip_noise(self) -> float:
        """What the noise of the accelerometer does to the slip of rolling wheels, as a variance of speed [m^2/s^2]."""
        compliance = self.compliance**2 + self._p[3][3]
        return compliance * (self._accelerometer.stddev * self.speed) ** 2

    @property
    def _scale(self) -> float:
        return 1.0 if self._measured is None else 1.0 - self.gain

    def start(self, speed: float, variance: float, by_wheels: float = 1.0) -> None:
        """Start at the last stamp with a speed [m/s] and its variance [m^2/s^2]; what is known of the others stays."""
        self._see()
        self.speed, self.by_wheels = speed, by_wheels
        self._forget(0, variance)
        self._by_age[0] = 0.0

    def predict(self, stamp: int, measured: float | None, *, observed: bool = True, sliding: bool = False) -> None:
        """Go to `stamp` [ns], later than the last.

        Args:
            stamp: new stamp [ns].
            measured: acceleration measured at the stamp [m/s^2], None if there is none.
            observed: whether speed measurements observe the offset at present.
            sliding: whether nothing does, as the wheels slide.
        """
        if (self._measured is None) != (measured is None):
            self._change_of_input(measured)
        if self._history:
            dt = (stamp - self._history[-1][0]) / NANOSECONDS
            p = self._parameters
            walk, noise = p.offset_walk**2, self._accelerometer.stddev**2
            if measured is None:
                walk, noise = p.acceleration_walk**2, 0.0
            step = (measured or 0.0) - (self._measured or 0.0)
            change = dt * (measured or 0.0) + self._delay * step
            driving = change - dt * self.offset
            self.speed += driving * (1.0 if measured is None else 1.0 - self.gain)
            before = self._mean
            self._mean += dt / (self._averaged + dt) * ((measured or 0.0) - before)
            self._by_age[0] += self._mean - before - dt * self._by_age[1]
            self._predict_covariance(dt, walk)
            self._p[0][0] += dt * dt * noise
            if measured is not None and abs(measured - self.offset) > p.telling:
                self._unseen_gain -= driving
            if observed:
                self._see()
            elif measured is not None:
                self._road.predict(dt, self.speed, sliding=sliding)
            self._travelled += change
            if dt > _GAP:
                self._p[0][0] += p.unknown_acceleration**2 * dt**2
        self._measured = measured
        self._history.append((stamp, self._travelled, self._mean))
        while self._history[0][0] < stamp - _HISTORY:
            self._history.popleft()

    def _by_delay(self) -> float:
        return self._by_age[0] ** 2 * self._delay_variance

    def _by_gain(self) -> float:
        g, p = self._unseen_gain, self._p
        return g * (2.0 * p[0][2] + g * p[2][2])

    def _predict_covariance(self, dt: float, walk: float) -> None:
        p, parameters = self._p, self._parameters
        row = [p[0][j] - dt * p[1][j] for j in _ALL]
        p[0][0] = row[0] - dt * row[1] + walk * dt**3 / 3.0
        for j in _OTHERS:
            p[0][j] = p[j][0] = row[j]
        p[0][1] = p[1][0] = row[1] - 0.5 * walk * dt * dt
        p[1][1] += walk * dt
        stay = exp(-dt / parameters.compliance_time)
        self.compliance = parameters.compliance + stay * (self.compliance - parameters.compliance)
        self._by_age[3] *= stay
        for j in (0, 1, 2):
            p[3][j] = p[j][3] = stay * p[3][j]
        p[3][3] = stay * stay * p[3][3] + (1.0 - stay * stay) * parameters.compliance_stddev**2

    def correct(
        self, speed: float, variance: float, stamp: int | None = None, effort: float = 0.0, by_wheels: float = 1.0
    ) -> bool:
        """Use a measured speed [m/s] with its variance [m^2/s^2], taken at `stamp` [ns] (None: now).

        Args:
            speed: the measured speed [m/s].
            variance: [m^2/s^2]
            stamp: when it was taken [ns].
            effort: deceleration by which the tyres of the wheels that measured it slip [m/s^2]; 0: they do not.
            by_wheels: 1 where wheels measured it, 0 where a speed sensor did.

        Returns:
            False if the filter was not running at that time, or it is too long ago: nothing is changed.
        """
        age, travelled, step = 0.0, 0.0, 0.0
        if stamp is not None:
            then = self._at(stamp)
            if then is None:
                return False
            age = (self._history[-1][0] - stamp) / NANOSECONDS
            travelled = self._travelled - then[0]
            step = self._history[-1][2] - then[1]
        self._see()
        return self._update(speed, variance, age, travelled, step, effort, by_wheels)

    def believe(self, speed: float, variance: float) -> None:
        """Use a speed [m/s] with its variance [m^2/s^2] as if the road had kept its slope."""
        self._update(speed, variance, 0.0, 0.0, 0.0, 0.0, 1.0)

    def refer(self, speed: float, variance: float, unseen: float) -> None:
        """Take a speed [m/s] with its variance [m^2/s^2] that is right whatever the road has done meanwhile.

        What the road did is learned and stays apart: it makes no other wheel more credible. A speed that is further off
        than it would be on a road that keeps its slope shows that the slope has changed. None is taken to explain more
        than one that has been there for all of the way; but one that began halfway is twice as steep, and stays.

        Args:
            speed: of the car [m/s].
            variance: [m^2/s^2]
            unseen: time since something last told the speed [s], > 0.
        """
        p, gap, slope = self._p, speed - self.speed, abs(speed - self.speed) / unseen
        changed = gap * gap > _SURPRISING**2 * (self.steady_road_variance + variance)
        if changed:
            self._road.doubt_past(slope * slope, unseen)
        total = self.speed_variance + variance
        known = self.speed_variance / total
        self.speed += known * gap
        self.offset += max(min((p[1][0] + self._road.total[1]) / total * gap, slope), -slope)
        p[1][1] -= p[1][0] ** 2 / total
        self._forget(0, known * variance)
        self._unseen_gain = self._by_age[0] = 0.0
        self._road.refer(total)
        if changed:
            self._road.doubt((_HALFWAY * slope) ** 2)

    def limit(self, variance: float) -> None:
        """Limit the variance of the speed to `variance` [m^2/s^2] without moving it.

        As a measurement that agrees where that is enough to take away what happened unseen, and else without a word on
        offset and gain: applied at every sample it would make the filter overconfident in bias and scale.
        """
        pv, total = self._p[0][0], self.speed_variance
        if total <= variance:
            return
        if pv < variance:
            kept = (variance - pv) / (total - pv)
            self._road.keep(kept)
            self._unseen_gain *= sqrt(kept)
            self._by_age[0] *= sqrt(kept)
        else:
            self._see()
            self._by_age[0] = 0.0
            p, share = self._p, sqrt(variance / self._p[0][0])
            for j in _ALL:
                p[0][j] *= share
                p[j][0] *= share

    def _update(
        self, speed: float, variance: float, age: float, travelled: float, step: float, effort: float, by_wheels: float
    ) -> bool:
        p = self._p
        driving = travelled - age * self.offset
        then = self.speed - driving * self._scale
        rolling = 1.0 - self.compliance * effort
        by_gain = rolling * driving if abs(driving) > self._parameters.telling * age else 0.0
        h = (rolling, rolling * age, by_gain, -then * effort)
        ph = [sum(p[i][j] * h[j] for j in _ALL) for i in _ALL]
        total = sum(h[i] * ph[i] for i in _ALL) + variance
        if not isfinite(total):
            return False
        innovation = speed - then * rolling
        self.surprise = innovation / sqrt(total)
        self.speed += ph[0] / total * innovation
        self.by_wheels += ph[0] / total * (by_wheels - self.by_wheels)
        self.offset += ph[1] / total * innovation
        self.gain += ph[2] / total * innovation
        # Where the tyres have little force it says nothing of c: a slope of the road would become a large one.
        told = abs(effort) >= self._parameters.telling
        if told:
            self.compliance += ph[3] / total * innovation
        of_age = (sum(h[i] * self._by_age[i] for i in _ALL) - rolling * step) / total
        kept = p[3][3], self._by_age[3]
        for i in _ALL:
            self._by_age[i] -= ph[i] * of_age
            for j in _ALL:
                p[i][j] -= ph[i] * ph[j] / total
        if not told:
            p[3][3], self._by_age[3] = kept
        if self.compliance < 0.0:
            self._keep_compliance()
        return True

    def _keep_compliance(self) -> None:
        """Move the state to a compliance of 0, the least there is: braked wheels do not turn faster than they roll."""
        p = self._p
        share = -self.compliance / p[3][3]
        self.speed += p[0][3] * share
        self.offset += p[1][3] * share
        self.gain += p[2][3] * share
        self.compliance = 0.0

    def _see(self) -> None:
        """Merge the unseen part into the covariance: it is observed from now on."""
        if self._unseen_gain:
            g, p = self._unseen_gain, self._p
            row = [p[0][j] + g * p[2][j] for j in _ALL]
            p[0][0] = row[0] + g * row[2]
            for j in _OTHERS:
                p[0][j] = p[j][0] = row[j]
            self._unseen_gain = 0.0
        uv, uc, ub = self._road.total
        if ub:
            p = self._p
            p[0][0] += uv
            p[0][1] += uc
            p[1][0] += uc
            p[1][1] += ub
            self._road.clear()

    def correct_course(self, speed: float, variance: float, offset: float, offset_variance: float) -> None:
        """Take speed [m/s] and offset [m/s^2] with their variances in place of those that wrong samples have made."""
        self._see()
        self.speed, self.offset = speed, offset
        self._forget(0, variance)
        self._forget(1, offset_variance)

    def doubt_offset(self, variance: float) -> None:
        """Widen the variance of the offset to at least `variance` [m^2/s^4]: it has changed."""
        self._see()
        self._p[1][1] = max(self._p[1][1], variance)

    def doubt_past_offset(self, variance: float, time: float) -> None:
        """Widen what is known as after a step of the offset `time` [s] ago, of a variance [m^2/s^4]."""
        self._road.doubt_past(variance, time)
        self._see()

    def doubt_road(self, variance: float) -> None:
        """Widen the unseen variance of the offset to at least `variance` [m^2/s^4]: the road may have changed."""
        self._road.doubt(variance)

    def doubt_drift(self, deviation: float, time: float) -> None:
        """Be no surer of the speed than `deviation` [m/s], as by a step of the road's slope `time` [s] ago, > 0."""
        missing = deviation * deviation - self.speed_variance
        if missing > 0.0:
            self._road.doubt_past(missing / (time * time), time)

    def _forget(self, index: int, variance: float) -> None:
        p = self._p
        for j in _ALL:
            p[index][j] = p[j][index] = 0.0
        p[index][index] = variance

    def change_since(self, stamp: int) -> float | None:
        """Return by how much the speed has changed since `stamp` [m/s]; None where that is too long ago."""
        then = self.travelled_at(stamp)
        if then is None:
            return None
        age = (self._history[-1][0] - stamp) / NANOSECONDS
        return (self._travelled - then - age * self.offset) * self._scale

    def travelled_at(self, stamp: int) -> float | None:
        """Return the integral of the measured acceleration up to `stamp` [m/s]; None where that is too long ago."""
        then = self._at(stamp)
        return None if then is None else then[0]

    def _at(self, stamp: int) -> tuple[float, float] | None:
        """Return that integral and the mean of the readings at `stamp`."""
        later: tuple[int, float, float] | None = None
        for known in reversed(self._history):
            if known[0] == stamp:
                return known[1], known[2]
            if known[0] < stamp:
                if later is None:
                    return None
                weight = (stamp - known[0]) / (later[0] - known[0])
                return known[1] + weight * (later[1] - known[1]), known[2] + weight * (later[2] - known[2])
            later = known
        return None

    def _change_of_input(self, measured: float | None) -> None:
        """Convert the offset when the accelerometer came or went; the acceleration of the car stays."""
        self._see()
        if measured is None:
            self._kept = (self.offset, self._p[1][1])
            self.offset -= self._measured or 0.0
            self._forget(1, self._parameters.unknown_acceleration**2)
        else:
            self.offset, variance = self._kept
            self._forget(1, variance)
        self._measured = measured


def _diagonal(*variances: float) -> list[list[float]]:
    return [[variance if i == j else 0.0 for j in _ALL] for i, variance in enumerate(variances)]
