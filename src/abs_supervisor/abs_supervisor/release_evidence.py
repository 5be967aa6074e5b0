"""Release conditions independent of the control law: slip or deceleration of the wheel."""

from enum import IntEnum
from math import inf, isfinite, nan, sqrt
from typing import Final

from abs_supervisor.own_fall import OwnFall
from abs_supervisor.rolling_scatter import RollingScatter
from abs_supervisor.tuning import EvidenceTuning
from abs_supervisor.wheel_motion import ORDINARY_STDDEV, WheelMotion
from friction_runtime.filters import Debounce
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING, SlowestCar


class Release(IntEnum):
    """Verdict on a release; the values are those of friction_msgs/SupervisorState."""

    NOT_WANTED = 0
    BY_SLIP = 1
    BY_DECELERATION = 2
    REFUSED = 3
    REFERENCE = 4


class Wheel:
    """What is known of the wheel at one stamp."""

    def __init__(
        self,
        speed: float,
        slip: float = nan,
        slip_stddev: float = nan,
        behind: float = nan,
        lambda_max: float = nan,
        lambda_max_stddev: float = nan,
        car_deceleration: float = nan,
        braked: bool = False,
        alike: bool = False,
        stands: bool = False,
    ) -> None:
        """Hold what is known; NaN where something is not.

        Args:
            speed: [rad/s].
            slip: [-].
            slip_stddev: [-].
            behind: share by which it turns slower than other wheels: the slip is at least that [-].
            lambda_max: of the curve [-].
            lambda_max_stddev: [-].
            car_deceleration: [m/s^2].
            braked: whether the brake acts, or the driver demands it.
            alike: whether the other wheels turn like this one, and nothing but the accelerometer says otherwise.
            stands: whether it and another wheel stand, or nearly, in a car that moves by what its wheels say alone.
        """
        self.speed = speed
        self.slip = slip
        self.slip_stddev = slip_stddev
        self.behind = behind
        self.lambda_max = lambda_max
        self.lambda_max_stddev = lambda_max_stddev
        self.car_deceleration = car_deceleration
        self.braked = braked
        self.alike = alike
        self.stands = stands


_PEAK_PER_SLIP: Final = 60.0
"""Error of lambda_max over an error of slip that the curve does not know of: a peak is flat."""
_NOISY: Final = 1.5
"""Noise of the wheel speed, in units of the ordinary, from which the curve does not know of it: less may be chance."""
_DEEP: Final = 2.0
"""Ratio slip/threshold that counts as deep slip."""
_STEADY: Final = 2.0
"""[m/s^2] A wheel that decelerates like the car, but for less, keeps its slip."""
_STEADY_TIME: Final = round(0.1 * NANOSECONDS)
"""[ns] for which it has to: a dive begins like that too."""
_STEADY_FACTOR: Final = 1.25
"""A slip that stays is that of a wheel before the peak: it must be larger by this factor."""
_HOLD_SLIP: Final = 0.14
"""Slip with which the pressure may be held while nothing is known of the road."""
_SUSPICIOUS: Final = 0.5
"""Share of the slip that a release needs."""
_FELL: Final = 0.2
"""[m/s] that a wheel is behind what a car can brake, or has lost more than its car: far more than its noise."""
_BIASED: Final = 2.5
"""[m/s^2] by which the deceleration of the car may be wrong where nothing but the accelerometer tells it."""
_CRAWLS: Final = 1.0
"""Rim speed [m/s] below which equal wheel speeds do not exclude lock-up."""
_RECOVERING: Final = 2.0
"""[m/s^2] of the circumference of a wheel that recovers."""
_DIVERGES: Final = 5.0
"""[m/s^2] by which a wheel beyond its peak loses more speed than its car."""
_FELL_BEHIND: Final = 0.25
"""Share of its own speed by which a wheel before its peak never falls behind."""
_PAST_PEAK: Final = 0.15
"""Share of its largest gain of speed by which a wheel gains less once it is before the peak again."""


class ReleaseEvidence:
    """Judges one wheel at one sample after the other."""

    def __init__(self, radius: float, parameters: EvidenceTuning) -> None:
        """Choose a wheel of effective radius `radius` [m]."""
        self._radius, self._p = radius, parameters
        lasts = round(parameters.evidence_time * NANOSECONDS)
        self._slip_lasts, self._dive_lasts = Debounce(lasts), Debounce(lasts)
        self._steady = Debounce(_STEADY_TIME)
        self._motion = WheelMotion()
        self._scatter = RollingScatter()
        self._slowest = SlowestCar()
        self._own = OwnFall(parameters.sigmas)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._motion.reset()
        self._scatter.reset()
        self._slowest.reset()
        self._own.reset()
        self._slip = nan
        for each in (self._slip_lasts, self._dive_lasts, self._steady):
            each.reset()
        self._dived = self._away = False
        self._largest_gain = 0.0
        self._slides = True
        self._lost = 0.0
        self._stamp: int | None = None
        self.dives = False
        """Whether the wheel decelerates as for a release, with at least half of the slip that a release needs."""
        self.allows_hold = False
        """Whether the pressure may be kept below the demand: the slip may well be as large as for a release.

        A hold takes nothing away, so the error of the slip counts for it, not against it.
        """
        self.may_slip = False
        """Whether the slip, with `sigmas` deviations of its error, may be one with which the pressure may be held.

        One that is not known may be."""
        self.grips = False
        """Whether the slip, as it is stated, is above the threshold without its error: more pressure gains little."""
        self.knows_slip = False
        """Whether slip is known: else nothing but wheels and accelerometer speaks for a release."""
        self.diverges = False
        """Whether the wheel loses speed as one beyond its peak does, or one whose brake still rises."""
        self.fell = False
        """Whether it has lost more of its own speed than a wheel before its peak does, or others show as much."""
        self.release_slip = nan
        """[-] slip above which a release is allowed."""
        self.deceleration = nan
        """[m/s^2] of the wheel's circumference, NaN where unknown."""
        self.release_deceleration = nan
        """[m/s^2] above which a release is allowed."""
        self.verdict = Release.REFUSED
        """What speaks for a release at the last sample: BY_SLIP, BY_DECELERATION, or REFUSED."""
        self.recovering = False
        """Whether the slip is above the threshold and the wheel is seen to gain speed."""
        self.stands = False
        """Whether the wheel and another one stand, or nearly, in a car that moves by what its wheels say alone."""

    @property
    def deep(self) -> bool:
        """Whether the wheel is beyond the peak: the slip speaks for a release by far, or it dived and is not back."""
        return self._away or (self.verdict is Release.BY_SLIP and self._slip > _DEEP * self.release_slip)

    def back_in(self, car_speed: float) -> float:
        """Return the time [s] after which a wheel that is seen to recover, as it does now, has the car's speed [m/s].

        Infinite where it does not recover, or nothing is known of its slip.
        """
        behind = self._slip * car_speed
        return behind / -self.deceleration if self.recovering and isfinite(behind) else inf

    @property
    def falls(self) -> bool:
        """Whether the wheel has fallen behind its own speed of late, and not all wheels together."""
        return self._own.holds and self._slides

    @property
    def scatter_is_learned(self) -> bool:
        """Whether the errors of the wheel's sensor were seen while it rolled freely."""
        return self._scatter.learned

    def update(self, stamp: int, wheel: Wheel) -> None:
        """Take what is known at a stamp [ns], later than the last."""
        p, motion = self._p, self._motion
        self.stands = wheel.stands
        motion.update(stamp, wheel.speed)
        stated = wheel.slip_stddev * wheel.slip_stddev if isfinite(wheel.slip_stddev) else 0.0
        self._scatter.update(stamp, wheel.braked, wheel.speed, motion.rate, wheel.slip, stated)
        rim = self._radius * wheel.speed
        slowest = self._slowest.update(stamp, rim)
        self._own.update(stamp, rim, self._radius * motion.noise, wheel.car_deceleration)
        # The least slip that is possible behind the wheel's own fastest speed: a car that brakes less hard has more.
        lag = (slowest - rim) / slowest if slowest > max(rim, 0.0) else 0.0
        self.deceleration = -self._radius * motion.rate
        rate_error = _root_of_squares(motion.rate_stddev, self._scatter.rate(max(wheel.speed, 0.0)))
        error = p.sigmas * self._radius * rate_error
        # Where all wheels dive, a speed that comes from them falls faster than any car can.
        own = min(wheel.car_deceleration, HARDEST_BRAKING) if isfinite(wheel.car_deceleration) else 0.0
        self.release_deceleration = max(p.deceleration * GRAVITY, own + p.deceleration_margin * GRAVITY) + error
        hardest = wheel.car_deceleration if 0.0 <= wheel.car_deceleration <= HARDEST_BRAKING else HARDEST_BRAKING
        self.diverges = self.deceleration - hardest > _DIVERGES + error
        self.fell = self._own.share > _FELL_BEHIND or max(lag, wheel.behind) > p.slip_without_curve
        base, doubt = self._slip_threshold(wheel)
        known = self.knows_slip = isfinite(wheel.slip)
        slip = self._slip = wheel.slip if known else wheel.behind
        self.allows_hold = slip + doubt > min(base, _HOLD_SLIP)
        self.may_slip = not known or max(slip, 0.0) + p.sigmas * doubt > min(base, _HOLD_SLIP)
        self.grips = slip > base
        follows = isfinite(wheel.car_deceleration) and abs(self.deceleration - own) < _STEADY + error
        steady = self._steady.update(stamp, follows)
        if steady:
            base *= _STEADY_FACTOR
        self.release_slip = base + p.sigmas * doubt
        self._lose(stamp, wheel.car_deceleration)
        if rim > _CRAWLS and (not wheel.alike or max(slowest - rim, self._lost) > _FELL):
            self._slides = True
        elif rim > _CRAWLS and (steady or slip < p.least_slip):
            self._slides = False
        # Wheels that keep together, and none faster than a car can brake: it is the speed of the car that is wrong.
        slip_shows = slip > self.release_slip and self._slides
        slip_lasts = self._slip_lasts.update(stamp, slip_shows)
        # A deceleration alone proves no lock: brakes are applied with several g of the wheel, at small slips.
        slips = slip > base + doubt if known else lag > p.least_slip + p.sigmas * self._scatter.slip
        hard = self.deceleration > self.release_deceleration
        self.dives = hard and slip > _SUSPICIOUS * base
        dive_lasts = self._dive_lasts.update(stamp, slips and hard)
        gain, least_gain = -self.deceleration, _RECOVERING + error
        unseen = not known and self.verdict is Release.BY_SLIP and gain < least_gain
        if unseen or dive_lasts:
            # A wheel that slips does so until it is seen to come back, also where its slip is not known any more.
            self._dived, self._largest_gain = True, 0.0
        elif known:
            # Once the wheel gains speed, a known slip alone decides.
            self._dived = self._dived and self.deceleration > 0.0 and slips
        else:
            # A braked wheel gains speed only on its way back to that of the car, and most at the peak of its curve.
            self._largest_gain = max(self._largest_gain, gain)
            lost = self._largest_gain - gain
            comes = gain > least_gain and lost < max(_PAST_PEAK * self._largest_gain, error)
            self._dived = self._dived and (comes or (self._largest_gain <= least_gain and lag > p.least_slip))
        self._away = self._dived and not known
        if slip_lasts:
            self.verdict = Release.BY_SLIP
        else:
            self.verdict = Release.BY_DECELERATION if self._dived else Release.REFUSED
        self.recovering = gain > least_gain and (slip_shows or self._away)

    def _lose(self, stamp: int, car_deceleration: float) -> None:
        """Add up the speed that the wheel loses beyond what its car may lose."""
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        # The wheel itself must fall: a car that gains speed where its wheels do not is an error of the speed.
        beyond = self.deceleration - max(car_deceleration, 0.0) - _BIASED
        self._lost = max(self._lost + beyond * dt, 0.0) if isfinite(beyond + car_deceleration) else 0.0

    def _slip_threshold(self, wheel: Wheel) -> tuple[float, float]:
        """Return the slip that a release needs, and the standard deviation of the slip's error."""
        p = self._p
        base = p.slip_without_curve
        if not isfinite(wheel.slip):
            # Other wheels slip too, and their radii differ: what they show is no small slip.
            return base, self._scatter.slip
        if isfinite(wheel.lambda_max):
            stated = wheel.lambda_max_stddev if isfinite(wheel.lambda_max_stddev) else 0.0
            unknown = _PEAK_PER_SLIP * _root_of_squares(self._scatter.slip_of_curve, self._noise_of_slip(wheel.speed))
            doubt = _root_of_squares(stated, unknown)
            known = p.lambda_max_share * (wheel.lambda_max + doubt)
            # A curve can only tell that less slip is enough: a peak that is far too large must not cost a lock.
            base = min(base, max(p.least_slip, known))
        stddev = wheel.slip_stddev if isfinite(wheel.slip_stddev) else 0.0
        return base, _root_of_squares(stddev, self._scatter.slip)

    def _noise_of_slip(self, wheel_speed: float) -> float:
        """Return the standard deviation of slip from a noise of the wheel speed that a curve does not know of [-]."""
        noise = self._motion.noise
        if noise < _NOISY * ORDINARY_STDDEV:
            return 0.0
        return min(sqrt(noise * noise - ORDINARY_STDDEV * ORDINARY_STDDEV) / max(wheel_speed, noise), 1.0)


def _root_of_squares(one: float, other: float) -> float:
    """Root of the sum of two squares."""
    return sqrt(one * one + other * other)
