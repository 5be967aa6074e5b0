"""Vehicle speed from wheels, accelerometer and speed sensor: which of them is trusted when.

- While the car rolls, the wheels correct the speed and the accelerometer's offset is learned. A wheel sample is used
  only `_BELIEF_LAG` after its stamp, at its own time, when nothing has shown that a slide had begun.
- While it slides, the corrected acceleration is integrated; the wheels are bounds: braked wheels are no faster than the
  car, driven ones no slower. The offset is no longer observed, so its uncertainty, and the speed's, grow with the road.
  A braked wheel that comes close to the integrated speed confirms it, and limits that uncertainty without moving it.
  One that the road carries for a moment, released by the brake, corrects it as far as integration alone has erred.
- A speed sensor corrects in either mode, at its own time, and starts the estimate at once.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import copysign, hypot, isfinite, sqrt
from statistics import median
from typing import Final

from friction_parameters.parameter import group, parameter
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.single_corner import GRAVITY
from vehicle_models.vehicle import Vehicle
from wheel_slip.carried_wheels import CarriedWheels
from wheel_slip.estimate import SpeedSource
from wheel_slip.slide_detector import SlideDetector, SlideParameters
from wheel_slip.speed_filter import SpeedFilter, SpeedFilterParameters
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.stuck_sensor import StuckSensor

_LOST_AFTER: Final = 1 * NANOSECONDS
"""Time without any sample [ns] after which the estimate starts again."""
_BELIEF_LAG: Final = round(0.1 * NANOSECONDS)
_SLIP_CORRELATION: Final = 0.1
"""Time [s] over which the slip of a rolling wheel counts as one error, not many."""
_BLIND_SPEED: Final = 0.6
_BLIND_STDDEV: Final = 0.1
"""Standard deviation of the speed where encoders read zero, as they do below about this rim speed [m/s]."""
_AT_REST: Final = 1.0
"""Largest apparent acceleration of a car that stands [m/s^2]."""
_BOUND_MARGIN: Final = 0.02
"""Share of the speed by which wheels may pass the bound: radii and torsional vibration."""
_SURPRISE: Final = 0.6
"""Mean innovation over its standard deviation that noise does not reach in hours: the road has changed its slope."""
_SURPRISE_TIME: Final = 0.2
"""Time over which that innovation is averaged [s]."""
_DOUBT: Final = 0.05
"""Standard deviation of the offset after such a change [m/s^2]."""
_CLOSE: Final = 0.1
"""Slip below which a wheel confirms the integrated speed, to half of that share."""
_STANDING: Final = 0.5
"""Time [s] over which the slip of a carried wheel counts as one error: longer than a supervisor leaves it released."""
_PLAUSIBLE: Final = 3.0
"""Standard deviations by which a carried wheel may differ from the integrated speed."""
_EFFORT: Final = 0.7
"""Acceleration from which on the slip of rolling wheels hides what the road does to the offset [m/s^2]."""
_STEP_AGO: Final = 0.3
"""Age of a step of the road's slope when wheels and accelerometer are seen to differ [s]."""
_DOUBT_EVERY: Final = round(0.5 * NANOSECONDS)
"""Time that a doubt of the offset needs to be settled [ns]."""
_FREE: Final = 0.3
"""Acceleration by drag and slope, for which tyres need no slip to speak of [m/s^2]."""
_SPRING_BACK: Final = 0.1
"""Time for which wheels must be beyond the bound [s]: released tyres spring back and turn them faster than the car."""
_BOUND_LATENCY: Final = 0.03
"""Time [s] by which wheel speeds may be older than the acceleration."""


@dataclass(frozen=True)
class VehicleSpeedParameters:
    """Which source is trusted when, and how much."""

    slip_per_acceleration: float = parameter(
        0.004,
        "uncertainty of a rolling wheel's slip per acceleration of the car",
        unit="s^2/m",
        minimum=0.0,
        maximum=0.1,
    )
    radius_uncertainty: float = parameter(
        0.002, "uncertainty of all radii together, as a share: speed from wheels is no better", minimum=0.0, maximum=0.1
    )
    sensor_timeout: float = parameter(
        0.5, "silence of vehicle_velocity after which the wheels take over", unit="s", minimum=0.01, maximum=10.0
    )
    speed_filter: SpeedFilterParameters = group(SpeedFilterParameters())
    slide: SlideParameters = group(SlideParameters())


class VehicleSpeed:
    """Speed of one car. `speed`, `variance` and so on mean something unless `source` is NONE."""

    def __init__(self, vehicle: Vehicle, parameters: VehicleSpeedParameters, wheel_speed_stddev: float) -> None:
        """Start without samples.

        Args:
            vehicle: the car.
            parameters: parameters of the estimate.
            wheel_speed_stddev: noise of a wheel speed [rad/s].
        """
        self._p = parameters
        self._rim_speed_variance = (wheel_speed_stddev * max(vehicle.radii)) ** 2
        self._filter = SpeedFilter(parameters.speed_filter, _gain_stddev(vehicle))
        self._radius_share = _radius_share(vehicle)
        self._slide = SlideDetector(parameters.slide, [wheel.driven for wheel in vehicle.wheels])
        self._carried = CarriedWheels(len(vehicle.wheels), self._rim_speed_variance)
        self._repetition = StuckSensor()
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._filter.reset()
        self._slide.reset()
        self._carried.reset()
        self._repetition.reset()
        self.accelerometer_is_stuck = False
        """Whether the accelerometer is left out because it repeats one value that every wheel contradicts."""
        self.source = SpeedSource.NONE
        """Where the speed comes from at the last sample."""
        self._sensor_stamp: int | None = None
        self._surprise = 0.0
        self._beyond = 0.0
        self._doubted: int | None = None
        self._not_yet_believed: deque[tuple[int, float, float, float]] = deque()
        self._last: int | None = None

    @property
    def speed(self) -> float:
        """Vehicle speed [m/s]."""
        return self._filter.speed

    @property
    def acceleration(self) -> float:
        """Acceleration [m/s^2], forward positive, corrected by the offset of the accelerometer."""
        return self._filter.acceleration

    @property
    def acceleration_variance(self) -> float:
        """Variance of the acceleration [m^2/s^4]."""
        return self._filter.acceleration_variance

    @property
    def offset(self) -> float:
        """Offset of the accelerometer [m/s^2]."""
        return self._filter.offset

    @property
    def disagreement(self) -> float:
        """Spread of the wheels about the speed [m/s]."""
        return self._slide.spread

    @property
    def variance(self) -> float:
        """Variance of the speed [m^2/s^2], including that of the radii, which scale every speed learned from wheels."""
        return self._filter.speed_variance + (self._p.radius_uncertainty * self._filter.speed) ** 2

    @property
    def stated_variance(self) -> float:
        """The same with what the radii have in common [m^2/s^2], which the slip of a wheel does not contain."""
        if self.source is SpeedSource.SENSOR:
            return self.variance
        return self.variance + (self._radius_share * self._filter.speed) ** 2

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        smooth_rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        acceleration: float | None,
        measured: Sequence[SpeedSample],
    ) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns], later than the last.
            rim_speeds: r omega of each wheel as measured [m/s], NaN where missing.
            smooth_rim_speeds: filtered rim speeds [m/s], NaN where unknown.
            rim_accelerations: filtered rates of the rim speeds [m/s^2].
            acceleration: reading of the accelerometer [m/s^2], None if there is none.
            measured: samples of the speed sensor.
        """
        if self._last is not None and stamp - self._last > _LOST_AFTER:
            self.reset()
        dt = (stamp - self._last) / NANOSECONDS if self._last is not None else _SLIP_CORRELATION
        started = self.source is not SpeedSource.NONE
        self.accelerometer_is_stuck = self._repetition.repeats(stamp, acceleration) and (
            self.accelerometer_is_stuck or not any(self._slide.rolling)
        )
        if self.accelerometer_is_stuck:
            acceleration = None
        effort = abs(self._slide.acceleration or 0.0)
        self._filter.predict(stamp, acceleration, observed=not (started and (self._slide.sliding or effort > _EFFORT)))
        integrated = (self._filter.speed, sqrt(self._filter.speed_variance)) if started else None
        slid = self._slide.sliding
        corrected = None if acceleration is None else acceleration - self._filter.offset
        offset_stddev = sqrt(self._filter.offset_variance)
        self._slide.update(
            stamp, smooth_rim_speeds, rim_accelerations, corrected, acceleration, offset_stddev, integrated
        )
        self._doubt_road(stamp)
        if slid and not self._slide.sliding and started and not self._sensor_is_fresh(stamp):
            self._return_to_wheels(smooth_rim_speeds)
        for sample in measured:
            self._use_sensor(sample)
        # Without an accelerometer only a speed sensor can distinguish a slide from braking.
        if self._slide.sliding or (acceleration is None and self._sensor_is_fresh(stamp)):
            self._not_yet_believed.clear()
            self._surprise = 0.0
            if self.source is not SpeedSource.NONE:
                self._bound(dt, rim_speeds)
                self._believe_carried(dt, rim_speeds)
        else:
            self._carried.reset()
            self._use_wheels(stamp, dt, rim_speeds)
        self._last = stamp
        if self.source is not SpeedSource.NONE:
            without_sensor = SpeedSource.INTEGRATED if self._slide.sliding else SpeedSource.WHEELS
            self.source = SpeedSource.SENSOR if self._sensor_is_fresh(stamp) else without_sensor

    def health_values(self, stamp: int) -> dict[str, str]:
        """Texts for diagnostics at a stamp [ns], by name."""
        known, slide = self._filter, self._slide
        since = slide.since
        time_in_mode = (stamp - since) / NANOSECONDS if since is not None else 0.0
        return {
            "speed source": self.source.name.lower(),
            "mode": "sliding" if slide.sliding else "rolling",
            "time in mode [s]": f"{time_in_mode:.1f}",
            "wheel disagreement [m/s]": f"{slide.spread:.3f}",
            "vehicle speed [m/s]": f"{known.speed:.3f}",
            "vehicle speed standard deviation [m/s]": f"{sqrt(known.speed_variance):.3f}",
            "accelerometer offset [m/s^2]": f"{known.offset:.3f}",
            "accelerometer offset standard deviation [m/s^2]": f"{sqrt(known.offset_variance):.3f}",
        }

    def _sensor_is_fresh(self, stamp: int) -> bool:
        timeout = self._p.sensor_timeout * NANOSECONDS
        return self._sensor_stamp is not None and stamp - self._sensor_stamp <= timeout

    def _use_sensor(self, sample: SpeedSample) -> None:
        if self.source is SpeedSource.NONE:
            self._filter.start(sample.speed, sample.variance)
        else:
            self._filter.correct(sample.speed, sample.variance, sample.stamp)
        self._sensor_stamp = sample.stamp
        self.source = SpeedSource.SENSOR

    def _use_wheels(self, stamp: int, dt: float, rim_speeds: Sequence[float]) -> None:
        believed = [rim_speeds[index] for index in self._slide.believed() if isfinite(rim_speeds[index])]
        if believed:
            speed = sum(believed) / len(believed)
            a = self._slide.acceleration or 0.0
            blind = abs(speed) < _BLIND_SPEED
            if not blind or abs(a) < _AT_REST:
                slip = self._p.slip_per_acceleration * speed * min(abs(a), _FREE)
                many = max(_SLIP_CORRELATION / dt, 1.0)
                noise = _BLIND_STDDEV**2 * many if blind else self._rim_speed_variance / len(believed)
                variance = noise + slip**2 * many
                self._not_yet_believed.append((stamp, speed, variance, self._effort()))
        if self.source is SpeedSource.NONE and self._not_yet_believed:
            _, speed, variance, effort = self._not_yet_believed.pop()
            slip = self._p.speed_filter.compliance_stddev * effort
            self._filter.start(speed * (1.0 + self._p.speed_filter.compliance * effort), variance + (slip * speed) ** 2)
            self._not_yet_believed.clear()
            self.source = SpeedSource.WHEELS
        while self._not_yet_believed and self._not_yet_believed[0][0] <= stamp - _BELIEF_LAG:
            when, speed, variance, effort = self._not_yet_believed.popleft()
            if self._filter.correct(speed, variance, when, effort):
                self._watch_offset(dt)

    def _doubt_road(self, stamp: int) -> None:
        """Where wheels that turn alike and accelerometer differ for long, the road may have changed its slope."""
        mismatch = self._slide.slope.mismatch
        if not mismatch or (self._doubted is not None and stamp - self._doubted <= _DOUBT_EVERY):
            return
        self._doubted = stamp
        if self._slide.sliding:
            self._filter.doubt_road(mismatch**2)
        else:
            self._filter.doubt_past_offset(mismatch**2, _STEP_AGO)

    def _effort(self) -> float:
        """Deceleration by which the tyres of the wheels that are believed slip [m/s^2]."""
        a = self._slide.acceleration or 0.0
        if a > 0.0 and self._slide.free_believed():
            return 0.0
        # On a slope that has been learned the corrected acceleration is that of the road: tyres need no slip for it.
        force = a + self._filter.offset if self._slide.acceleration is not None else 0.0
        if a * force <= 0.0:
            return 0.0
        return -copysign(max(min(abs(a), abs(force)) - _FREE, 0.0), a)

    def _return_to_wheels(self, smooth_rim_speeds: Sequence[float]) -> None:
        """Take the speed from the wheels.

        The error of the integration is not attributed to the offset: lag and scale of the accelerometer may have caused
        it as well, and the next slide would begin with a wrong offset.
        """
        believed = [smooth_rim_speeds[index] for index in self._slide.believed()]
        if not believed:
            believed = [speed for speed in smooth_rim_speeds if isfinite(speed)]
        speed = median(believed)
        effort = self._effort()
        if self._slide.agreed:
            self._filter.correct(speed, self._rim_speed_variance, None, effort)
        else:
            p = self._p.speed_filter
            slip = p.compliance_stddev * effort
            self._filter.start(speed * (1.0 + p.compliance * effort), self._rim_speed_variance + (slip * speed) ** 2)
        if self._slide.contradicted:
            self._filter.doubt_offset(self._p.speed_filter.offset_stddev**2)

    def _watch_offset(self, dt: float) -> None:
        """Learn the offset again when the innovations of the wheels stay on one side."""
        self._surprise += min(dt / _SURPRISE_TIME, 1.0) * (self._filter.surprise - self._surprise)
        if abs(self._surprise) > _SURPRISE:
            self._filter.doubt_offset(_DOUBT**2)

    def _bound(self, dt: float, rim_speeds: Sequence[float]) -> None:
        """Keep the speed above braked and below driven wheels; two of them must agree, for one may vibrate or fail."""
        a = self._slide.acceleration
        known = sorted(speed for speed in rim_speeds if abs(speed) > _BLIND_SPEED)
        if a is None or not known:
            return
        noise = 3.0 * sqrt(self._rim_speed_variance)
        margin = _BOUND_MARGIN * abs(self._filter.speed) + _BOUND_LATENCY * abs(a) + noise
        second = min(1, len(known) - 1)
        many = max(_SLIP_CORRELATION / dt, 1.0)
        if len(known) == 1 < len(rim_speeds):
            # Where the others are blind, it may be stuck at the speed of a car that has become slow with them.
            likely = _PLAUSIBLE * sqrt(self._filter.speed_variance) + margin
            if abs(known[0] - self._filter.speed) > likely:
                return
        beyond = 0.0
        if a < -1.0:
            beyond = known[-1 - second] - margin - self._filter.speed
            if known[-1 - second] > (1.0 - _CLOSE) * self._filter.speed:
                self._filter.limit((0.5 * _CLOSE * self._filter.speed) ** 2 + margin**2)
        elif a > 1.0:
            beyond = self._filter.speed - known[second] - margin
        self._beyond = self._beyond + dt if beyond > 0.0 else 0.0
        if self._beyond >= _SPRING_BACK:
            self._filter.correct(self._filter.speed - copysign(beyond, a), margin**2 * many)

    def _believe_carried(self, dt: float, rim_speeds: Sequence[float]) -> None:
        """Correct the speed by the fastest wheel that the road carries, if it is where the speed may be.

        That is judged, and corrected, as on a road that keeps its slope: wheels may also stand still in a slip, and the
        more the road may have done meanwhile the more of that would pass for the speed.
        """
        car, a = self._filter, self._slide.acceleration
        if a is None:
            return
        gaps = self._carried.update(dt, rim_speeds, car.speed)
        if gaps:
            gap = max(gaps)
            slip = self._p.slip_per_acceleration * car.speed * a
            variance = self._carried.gap_variance(dt) + slip**2
            if gap**2 < _PLAUSIBLE**2 * (car.steady_road_variance + variance):
                car.believe(car.speed + gap, variance * max(_STANDING / dt, 1.0))


def _gain_stddev(vehicle: Vehicle) -> float | None:
    """Deviation of the accelerometer's gain as a share, by scale and pitch; None where the vehicle file states none."""
    known = vehicle.accelerometer.deviations
    if "scale" not in known:
        return None
    pitch = known["pitch_gain"].stddev if "pitch_gain" in known else 0.0
    return hypot(known["scale"].stddev / vehicle.accelerometer.scale, GRAVITY * pitch)


def _radius_share(vehicle: Vehicle) -> float:
    """Deviation of the radii as a share, 0 where the vehicle file states none."""
    shares = [each.deviations["radius"].stddev / each.radius for each in vehicle.wheels if "radius" in each.deviations]
    return max(shares, default=0.0)
