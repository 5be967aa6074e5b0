"""Slip monitor: the slip of a wheel that is proven, and whether the wheel itself confirms it.

A proof is one number, the *proven slip*: what is left of the slip without three of its standard deviations, or the
least slip that the wheel speeds alone allow. Slip, speed and curve may be valid and wrong, and then all of them ask for
a release in a braking that is none of a lock. So the first release of a braking needs a witness that shares no error
with them: beyond its peak a wheel loses speed although its brake does not rise; before it, it keeps its slip.
"""

from math import hypot, isfinite, nan, sqrt
from typing import Final

from abs_supervisor.measurements import GAP, Measurements
from abs_supervisor.reference_speed import ReferenceSpeed
from friction_runtime.filters import Debounce, SlidingWindow
from sensor_monitor.signal_noise import SignalNoise
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING, SlowestCar

# Threshold of the proven slip
CURVE_RATIO: Final = 0.5
"""[-] of lambda_max."""
LEAST_SLIP: Final = 0.03
"""[-]"""
SLIP_WITHOUT_CURVE: Final = 0.2
"""[-]"""
DEEP: Final = 1.5
"""[-] of the threshold: far beyond the peak."""
SIGMAS: Final = 3.0
"""Standard deviations of an error that a proof leaves room for."""
PROOF_TIME: Final = 0.01
"""[s]"""
HOLD_SLIP: Final = 0.14
"""[-] largest slip from which the pressure may be held while the road is unknown."""
# Errors
WHEEL_NOISE, LEAST_NOISE = 0.07, 0.02
"""[rad/s] of the wheel speed of section 8.3.2; no encoder is better than the second."""
NOISY: Final = 1.5
"""[-] of WHEEL_NOISE, from which on neither the curve nor the motion of a wheel is evidence: ripple of its encoder."""
BIASED_SLIP: Final = 0.007
"""[-] mean slip of a wheel that rolls freely, from which on the curve is no evidence: as above."""
BIAS_TIME: Final = 0.3
"""[s] over which it is averaged."""
ACCELEROMETER_ERROR: Final = 2.5
"""[m/s^2]"""
# The wheel's own motion
SMOOTH: Final = 0.015
"""[s] over which wheel speed and brake torque are averaged."""
DIVERGES: Final = 5.0
"""[m/s^2] by which a wheel beyond its peak loses more speed than its car."""
TORQUE_STEP, TORQUE_RATIO = 5.0, 0.02
"""[N m] and share of the torque by which one that does not rise may be above its average."""
STILL, LASTING = 0.02, 0.8
"""[s] over which a brake does not rise, and [-] of the wheel's deceleration beyond that of its car that is left then:
before its peak a wheel follows its brake with the time constant of its tyre, at most 45 ms, which leaves 0.65."""
FELL: Final = 0.3
"""[-] of its own speed by which a wheel before its peak never falls behind."""
FALLS: Final = 0.05
"""[-] of it by which a wheel falls behind that is at its peak."""
FORGETS: Final = 0.3
"""[m/s^2] by which the wheel's own speed is carried on faster than its car slows down: errors fade."""
LOST: Final = 0.2
"""[m/s] that a wheel has lost against its car: far more than its noise."""
FOLLOWS, FOLLOWS_TIME = 3.0, 0.1
"""[m/s^2] and [s]: a wheel that decelerates like its car for so long keeps its slip."""
RECOVERS: Final = 2.0
"""[m/s^2] acceleration of a wheel that comes back."""
BACK: Final = 0.15
"""[-] of its largest acceleration by which one that is back gains less."""


class SlipMonitor:
    """Follows one wheel: `update` at every sample."""

    def __init__(self, radius: float) -> None:
        """Choose a wheel of an effective radius [m]."""
        self._radius = radius
        self._noise = SignalNoise(WHEEL_NOISE**2, LEAST_NOISE**2)
        self._own = SlowestCar()
        self._proof, self._hard = Debounce(PROOF_TIME * NANOSECONDS), Debounce(PROOF_TIME * NANOSECONDS)
        self._follows, self._still = Debounce(FOLLOWS_TIME * NANOSECONDS), Debounce(STILL * NANOSECONDS)
        self._beyond: SlidingWindow[float] = SlidingWindow(STILL * NANOSECONDS)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        for each in (self._noise, self._own, self._proof, self._hard, self._follows, self._still):
            each.reset()
        self._beyond.clear()
        self._stamp = 0
        self._rim = self._carried = self._torque = nan
        self._lost = self._bias = self._gain = 0.0
        self._slides, self._dived, self._slipped = True, False, False
        self.deceleration = nan
        """[m/s^2] of the wheel's circumference."""
        self.threshold = nan
        """[-] slip from which on a release helps: half of lambda_max."""
        self.release_slip = nan
        """[-] slip that is a proof: the threshold and three standard deviations of the slip."""
        self.proven = False
        """Whether the wheel is proven to slip, and shows it itself, or others beside it do."""
        self.possible = False
        """Whether the slip may be that of a release: a hold takes nothing away, so errors count for it."""
        self.slips = False
        """Whether the slip as stated is above the threshold."""
        self.deep = False
        """Whether the slip as stated is far beyond the peak, or was before it became unknown."""
        self.dives = False
        """Whether the wheel is on its way to a lock, or has been and is not seen to be back."""
        self.falls = False
        """Whether the wheel has fallen behind its own speed of the last second by 5 %."""
        self.recovers = False
        """Whether the wheel gains speed."""

    def update(
        self,
        stamp: int,
        measured: Measurements,
        car: ReferenceSpeed,
        lambda_max: float,
        lambda_max_stddev: float,
        braked: bool,
    ) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            measured: its wheel speed is finite.
            car: at the same stamp.
            lambda_max: of the friction curve [-], NaN where none is known.
            lambda_max_stddev: [-].
            braked: whether the brake acts, or the driver demands it.
        """
        dt = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        rim = self._radius * measured.wheel_speed
        hardest = car.deceleration if 0.0 <= car.deceleration <= HARDEST_BRAKING else HARDEST_BRAKING
        still = self._still.update(stamp, not self._move(rim, measured.torque, dt, car.deceleration, hardest))
        self._noise.update(stamp, measured.wheel_speed)
        own = self._own.update(stamp, rim)
        lag = (own - rim) / own if own > max(rim, 0.5) else 0.0
        known, slip = isfinite(measured.slip), measured.slip
        if known and not braked:
            self._bias += (abs(slip) - self._bias) * min(dt / BIAS_TIME, 1.0)
        stddev = hypot(measured.slip_stddev, self._bias) if isfinite(measured.slip_stddev) else self._bias
        noise = sqrt(self._noise.variance)
        quiet = noise < NOISY * WHEEL_NOISE
        self._limit(stddev, lambda_max if quiet and self._bias < BIASED_SLIP else nan, lambda_max_stddev)
        self._trust(stamp, car, slip, own - rim, hardest)
        # What the wheel speeds alone allow.
        least = max(lag, car.behind) if isfinite(car.behind) else lag
        proven = max(slip - SIGMAS * stddev if known and self._slides else 0.0, least)
        fall = 1.0 - self._rim / self._carried if self._carried > 0.5 else 0.0
        self.falls = fall > FALLS + SIGMAS * 0.5 * noise * self._radius / max(rim, 1.0)
        beyond = self.deceleration - hardest
        self._beyond.append(stamp, beyond)
        lasts = quiet and still and beyond > max(DIVERGES, LASTING * next(iter(self._beyond))[1])
        shows = proven > self.threshold
        witnessed = lasts or fall > FELL or least > SLIP_WITHOUT_CURVE
        error = SIGMAS * noise * self._radius / SMOOTH
        hard = self.deceleration > HARDEST_BRAKING + error and lag > LEAST_SLIP and (lasts or lag > SLIP_WITHOUT_CURVE)
        self._dive(known, self._hard.update(stamp, hard), lag, error)
        self.recovers = self.deceleration < -RECOVERS
        goes_on = self.proven and shows and not self.recovers
        self.proven = self._proof.update(stamp, shows and witnessed) or self._dived or goes_on
        self.possible = not known or slip + stddev > min(self.threshold, HOLD_SLIP)
        self.slips = known and slip > self.threshold
        self.deep = self._dived or (known and slip > DEEP * self.threshold)
        self.dives = self._dived or (known and slip > 0.5 * self.threshold and self.deceleration > HARDEST_BRAKING)

    def _move(self, rim: float, torque: float, dt: float, deceleration: float, hardest: float) -> bool:
        """Follow the wheel's own motion; return whether its brake rises."""
        before = self._rim
        if not isfinite(before) or dt > GAP:
            self._rim, self.deceleration, self._lost, self._carried, self._torque = rim, 0.0, 0.0, rim, torque
            return True
        share = min(dt / SMOOTH, 1.0)
        self._rim += (rim - before) * share
        self.deceleration = (before - self._rim) / dt
        self._carried = max(self._carried - (hardest + FORGETS) * dt, self._rim)
        beyond = self.deceleration - deceleration - ACCELEROMETER_ERROR
        self._lost = max(self._lost + beyond * dt, 0.0) if isfinite(beyond) else 0.0
        self._torque = torque if not isfinite(self._torque) else self._torque + (torque - self._torque) * share
        return not torque - self._torque < TORQUE_STEP + TORQUE_RATIO * torque

    def _limit(self, stddev: float, lambda_max: float, lambda_max_stddev: float) -> None:
        """Set the thresholds, for a standard deviation of the slip [-]."""
        self.threshold = SLIP_WITHOUT_CURVE
        if isfinite(lambda_max):
            self.threshold = min(max(CURVE_RATIO * (lambda_max + lambda_max_stddev), LEAST_SLIP), SLIP_WITHOUT_CURVE)
        self.release_slip = self.threshold + SIGMAS * stddev

    def _trust(self, stamp: int, car: ReferenceSpeed, slip: float, behind: float, hardest: float) -> None:
        """See whether the slip may be an error of the speed: wheels turn alike, and none fell more than its car."""
        steady = self._follows.update(stamp, abs(self.deceleration - hardest) < FOLLOWS)
        if not car.alike or max(behind, self._lost) > LOST:
            self._slides = True
        elif steady or slip < LEAST_SLIP:
            self._slides = False

    def _dive(self, known: bool, hard: bool, lag: float, error: float) -> None:
        """See whether a wheel of unknown slip dives, or has dived and is not back; its acceleration errs by `error`."""
        gain = -self.deceleration
        if known:
            self._dived, self._slipped = False, self.proven
            return
        self._slipped = self._slipped and gain < RECOVERS + error
        if hard or self._slipped:
            # It slips until it is seen to come back.
            self._dived, self._gain = True, 0.0
        elif self._dived:
            # A braked wheel gains speed only on its way back, and most at the peak of its curve.
            self._gain = max(self._gain, gain)
            comes = gain > RECOVERS and self._gain - gain < max(BACK * self._gain, error)
            self._dived = comes or (self._gain <= RECOVERS + error and lag > LEAST_SLIP)
