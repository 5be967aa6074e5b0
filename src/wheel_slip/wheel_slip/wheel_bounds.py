"""Bounds on the speed from sliding wheels, and wheels that roll for a moment.

Braked wheels are no faster than the car, driven ones no slower. A braked wheel that comes close to the integrated speed
confirms it, and limits its uncertainty without moving it. One that the road carries corrects it as far as integration
alone has erred, one whose brake is seen to open whatever the road has done.
"""

from collections.abc import Sequence
from math import copysign, sqrt

from wheel_slip.carried_wheels import CarriedWheels
from wheel_slip.close_wheel import CloseWheel
from wheel_slip.released_wheels import ReleasedWheels
from wheel_slip.speed_filter import SpeedFilter
from wheel_slip.tuning import BoundTuning


class WheelBounds:
    """The wheels of one car."""

    def __init__(
        self,
        parameters: BoundTuning,
        count: int,
        rim_speed_variance: float,
        slip_per_acceleration: float,
        lowest_speed: float,
        steepest: float,
    ) -> None:
        """Start without samples.

        Args:
            parameters: parameters of the bounds.
            count: number of wheels.
            rim_speed_variance: noise of a rim speed [m^2/s^2].
            slip_per_acceleration: uncertainty of a rolling wheel's slip per acceleration of the car [s^2/m].
            lowest_speed: rim speed below which encoders read zero [m/s].
            steepest: difference that the slope of a road makes at most [m/s^2].
        """
        self._p = parameters
        self._variance = rim_speed_variance
        self._slip_per_acceleration = slip_per_acceleration
        self._lowest = lowest_speed
        self._close = CloseWheel(parameters.close, parameters.spring_back, parameters.comes_again, steepest)
        self._carried = CarriedWheels(parameters.carried, count, rim_speed_variance)
        self._released = ReleasedWheels(parameters.released, count)
        self._beyond = 0.0
        self._unseen = 0.0

    def reset(self) -> None:
        """Forget everything."""
        self.begin_slide()
        self._beyond = 0.0

    def know_noise(self, rim_speed_variance: float) -> None:
        """Take the noise of a rim speed [m^2/s^2]."""
        self._variance = self._carried.noise = rim_speed_variance

    def begin_slide(self) -> None:
        """Know of no wheel that it is carried."""
        self._close.reset()
        self._carried.reset()
        self._released.reset()
        self._unseen = 0.0

    def use(
        self,
        car: SpeedFilter,
        dt: float,
        rim_speeds: Sequence[float],
        torques: Sequence[float],
        acceleration: float,
        correlation: float,
        direction: float,
    ) -> None:
        """Correct the speed by one sample.

        Args:
            car: the speed, which is corrected.
            dt: time since the last sample [s].
            rim_speeds: r omega of each wheel as measured [m/s], NaN where missing.
            torques: of the brakes [N m], NaN where unknown.
            acceleration: of the car, with the lag of the wheels [m/s^2].
            correlation: time over which the slip of a wheel counts as one error [s].
            direction: 1.0, or -1.0 in reverse.
        """
        ahead = rim_speeds if direction > 0.0 else [-each for each in rim_speeds]
        a = direction * acceleration
        self._bound(car, dt, ahead, a, max(correlation / dt, 1.0), direction)
        self._believe_carried(car, dt, ahead, a, direction)
        self._refer(car, dt, ahead, torques, direction)

    def _bound(
        self, car: SpeedFilter, dt: float, rim_speeds: Sequence[float], a: float, many: float, direction: float
    ) -> None:
        """Keep the speed above braked and below driven wheels; two of them must agree, for one may vibrate or fail."""
        known = sorted(speed for speed in rim_speeds if abs(speed) > self._lowest)
        if not known:
            return
        p, speed = self._p, direction * car.speed
        margin = p.margin * abs(speed) + p.latency * abs(a) + p.carried.plausible * sqrt(self._variance)
        second = min(1, len(known) - 1)
        if len(known) == 1 < len(rim_speeds):
            # Where the others are blind, it may be stuck at the speed of a car that has become slow with them.
            likely = p.carried.plausible * sqrt(car.speed_variance) + margin
            if abs(known[0] - speed) > likely:
                return
        beyond = 0.0
        if a < -p.effort_above:
            fastest = known[-1 - second]
            beyond = fastest - margin - speed
            if speed > 0.0:
                self._confirm(car, dt, fastest, speed, -a, margin)
        elif a > p.effort_above:
            beyond = speed - known[second] - margin
        self._beyond = self._beyond + dt if beyond > 0.0 else 0.0
        if self._beyond >= p.spring_back:
            # The wheel still slips, by as much as one that confirms the speed.
            slip = 0.5 * p.close * speed
            gap = copysign(beyond + margin + slip, a)
            car.correct(direction * (speed - gap), (margin**2 + slip**2) * many)

    def _confirm(
        self, car: SpeedFilter, dt: float, rim_speed: float, speed: float, deceleration: float, margin: float
    ) -> None:
        """Be as sure of the speed as the closest wheel allows."""
        close = self._close
        confirmed = close.update(dt, 1.0 - rim_speed / speed, speed, deceleration)
        if confirmed is not None:
            car.limit((confirmed * speed) ** 2 + margin**2)
        if close.drift:
            car.doubt_drift(close.drift * speed, close.lasted)

    def _believe_carried(
        self, car: SpeedFilter, dt: float, rim_speeds: Sequence[float], a: float, direction: float
    ) -> None:
        """Correct the speed by the fastest wheel that the road carries, if it is where the speed may be.

        That is judged, and corrected, as on a road that keeps its slope: wheels may also stand still in a slip, and the
        more the road may have done meanwhile the more of that would pass for the speed. So a speed that has become
        doubtful makes no larger gap plausible.
        """
        speed = direction * car.speed
        gaps = self._carried.update(dt, rim_speeds, speed)
        if gaps:
            gap = max(gaps)
            slip = self._slip_per_acceleration * speed * a
            variance = self._carried.gap_variance(dt) + slip**2
            known = car.steady_road_variance
            doubt = max(known - (self._p.margin * speed) ** 2, 0.0)
            if gap**2 < self._p.carried.plausible**2 * (known - doubt + variance):
                car.believe(direction * (speed + gap), (variance + doubt) * max(self._p.carried.released / dt, 1.0))

    def _refer(
        self, car: SpeedFilter, dt: float, rim_speeds: Sequence[float], torques: Sequence[float], direction: float
    ) -> None:
        """Take the speed from a wheel whose brake has opened, whatever the road has done meanwhile."""
        self._unseen += dt
        speed = direction * car.speed
        if not torques or speed <= self._lowest:
            return
        gap = self._released.update(dt, torques, rim_speeds, speed, self._variance)
        if gap is not None:
            slip = self._p.released.slip * speed
            car.refer(direction * (speed + gap), self._variance + slip**2, self._unseen)
            self._unseen = 0.0
