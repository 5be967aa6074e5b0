"""Vehicle speed from wheels, accelerometer and speed sensor: what is done in each mode (mode.py).

- While the car rolls, the wheels correct the speed and the accelerometer's offset is learned. A wheel sample is used
  only `rolling.lag` after its stamp, at its own time, when nothing has shown that a slide had begun.
- While it slides, the corrected acceleration is integrated and the wheels are bounds (wheel_bounds.py). The offset is
  no longer observed, so its uncertainty, and the speed's, grow with the road.
- A speed sensor corrects in either mode, at its own time, and starts the estimate at once.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import copysign, hypot, isfinite, sqrt
from statistics import median
from typing import Final

from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle, deviation_of, specified_stddev
from wheel_slip.accelerometer_watch import AccelerometerWatch
from wheel_slip.estimate import SOURCES, Mode, SpeedSource
from wheel_slip.mode import Cause, transition
from wheel_slip.radius_doubt import RadiusDoubt
from wheel_slip.slide_detector import SlideDetector
from wheel_slip.speed_filter import AccelerometerParameters, SpeedFilter
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.speed_sensor import SpeedSensor
from wheel_slip.tuning import Tuning
from wheel_slip.wheel_bounds import WheelBounds

_SURE_OF_DELAY: Final = 2.0
"""Deviations by which the accelerometer may be later than the vehicle file states."""
_BRAKED: Final = -0.5
"""Acceleration below which wheels may be braked [m/s^2]."""
_AT_REST: Final = 2.5
"""Standstill threshold [bias standard deviations]."""


class VehicleSpeed:
    """Speed of one car. Outputs are valid unless `source` is NONE."""

    def __init__(
        self,
        vehicle: Vehicle,
        tuning: Tuning,
        accelerometer: AccelerometerParameters,
        wheel_speed_stddev: float,
        sensor_timeout: float,
    ) -> None:
        """Start without samples.

        Args:
            vehicle: the car.
            tuning: of the estimate.
            accelerometer: its noise and offset.
            wheel_speed_stddev: noise of a wheel speed [rad/s].
            sensor_timeout: silence of the speed sensor after which the wheels take over [s].
        """
        self._p = tuning
        accelerometer = _of_car(accelerometer, vehicle)
        self._offset_stddev = accelerometer.bias_stddev
        self._largest_radius = max(vehicle.radii)
        self._rim_speed_variance = (wheel_speed_stddev * self._largest_radius) ** 2
        mounting = vehicle.accelerometer
        self._filter = SpeedFilter(
            accelerometer,
            tuning.speed_filter,
            _gain_stddev(vehicle),
            mounting.delay,
            specified_stddev(mounting.deviations, "delay"),
        )
        self.radii = RadiusDoubt(vehicle)
        """How far the radii make the speed wrong."""
        self._slide = SlideDetector(tuning.slide, tuning.slope, [wheel.driven for wheel in vehicle.wheels])
        self._bounds = WheelBounds(
            tuning.bounds,
            len(vehicle.wheels),
            self._rim_speed_variance,
            tuning.slip_per_acceleration,
            self._p.slide.blind_below,
            tuning.slope.steepest,
        )
        self._accelerometer = AccelerometerWatch(
            tuning.slide,
            mounting.delay + _SURE_OF_DELAY * deviation_of(mounting.deviations, "delay", 0.0),
        )
        self._sensor = SpeedSensor(tuning, sensor_timeout, self._filter, self._slide, self.radii)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._filter.reset()
        self._slide.reset()
        self._bounds.reset()
        self._accelerometer.reset()
        self._sensor.reset()
        self.mode = Mode.WAITING
        """Mode at the last sample."""
        self.cause = Cause.STARTED
        """Why it was entered."""
        self._since: int | None = None
        self._force: float | None = None
        self._surprise = 0.0
        self._doubted: int | None = None
        self.radii.reset()
        self._not_yet_believed: deque[tuple[int, float, float]] = deque()
        self._last: int | None = None

    def know_noise(self, variance: float) -> None:
        """Take the variance of a wheel speed [rad^2/s^2] in place of the stated one."""
        self._rim_speed_variance = variance * self._largest_radius**2
        self._bounds.know_noise(self._rim_speed_variance)

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
    def is_unbraked(self) -> bool:
        """True while coasting; always true without an accelerometer."""
        return _BRAKED < self._slide.direction * (self._slide.acceleration or 0.0) < self._p.slide.roll_below

    @property
    def disagreement(self) -> float:
        """Spread of the wheels about the speed [m/s]."""
        return self._slide.spread

    @property
    def variance(self) -> float:
        """Variance of the speed [m^2/s^2], with what does not average out: radii, and what is known of the sensor."""
        known = self._filter.speed_variance + (self._p.radius_uncertainty * self._filter.speed) ** 2
        known += self._sensor.undecided_variance
        return known + self._sensor.age_variance if self.source is SpeedSource.SENSOR else known

    @property
    def stated_variance(self) -> float:
        """The same with what the radii have in common [m^2/s^2], which the slip of a wheel contains as far as not."""
        by_radii = (self.radii.common**2 + self.radii.of_mean) * self._filter.by_wheels**2
        return self.variance + by_radii * self._filter.speed**2

    @property
    def radii_against_speed(self) -> float:
        """Deviation of what all radii have in common against the speed, as a share: that of every slip."""
        return self.radii.common * (1.0 - self._filter.by_wheels)

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        smooth_rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        acceleration: float | None,
        measured: Sequence[SpeedSample],
        torques: Sequence[float] = (),
    ) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns], later than the last.
            rim_speeds: r omega of each wheel as measured [m/s], NaN where missing.
            smooth_rim_speeds: filtered rim speeds [m/s], NaN where unknown.
            rim_accelerations: filtered rates of the rim speeds [m/s^2].
            acceleration: reading of the accelerometer [m/s^2], None if there is none.
            measured: samples of the speed sensor.
            torques: of the brakes [N m], NaN where unknown; empty where no brake is known.
        """
        if self._last is not None and stamp - self._last > self._p.forget_after * NANOSECONDS:
            self.reset()
        dt = (stamp - self._last) / NANOSECONDS if self._last is not None else self._p.rolling.correlation
        self._last = stamp
        if self._accelerometer.leaves_out(
            stamp, acceleration, smooth_rim_speeds, self._slide.rolling, self._filter.offset
        ):
            acceleration = None
        self._predict(stamp, dt, acceleration, smooth_rim_speeds, rim_accelerations)
        if acceleration is not None:
            self._sensor.follow(stamp)
        at_wheels = self._at_wheels(rim_speeds)
        if measured:
            gauged = acceleration is not None
            measured = self._judged(stamp, measured, at_wheels, smooth_rim_speeds, rim_accelerations, gauged)
        starting = self.mode is Mode.WAITING
        self._change_mode(stamp, smooth_rim_speeds, at_wheels is not None)
        if self.mode is not Mode.WAITING:
            for sample in measured:
                self._sensor.use(sample, starting)
                starting = False
        # Without an accelerometer only a speed sensor can distinguish a slide from braking.
        if self.mode is Mode.ROLLING or (self.mode is Mode.SENSOR_ROLLING and acceleration is not None):
            self._use_wheels(stamp, dt, at_wheels, starting)
        else:
            self._not_yet_believed.clear()
            self._surprise = 0.0
            a = self._slide.acceleration
            if self.mode is not Mode.WAITING and a is not None:
                self._bounds.use(
                    self._filter, dt, rim_speeds, torques, a, self._p.rolling.correlation, self._slide.direction
                )

    def _predict(
        self,
        stamp: int,
        dt: float,
        acceleration: float | None,
        smooth_rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
    ) -> None:
        """Go to the sample, and judge the wheels there."""
        started = self.mode is not Mode.WAITING
        effort = abs(self._slide.acceleration or 0.0)
        observed = not (started and (self._is_sliding or effort > self._p.speed_filter.telling))
        # In a slide beside a speed sensor that sensor tells of the road.
        self._filter.predict(stamp, acceleration, observed=observed, sliding=self.mode is Mode.SLIDING)
        self._slide.update(
            stamp,
            smooth_rim_speeds,
            rim_accelerations,
            None if acceleration is None else acceleration - self._filter.offset,
            acceleration,
            sqrt(self._filter.offset_variance),
            sqrt(self._filter.undoubted_offset_variance),
            (self._filter.speed, sqrt(self._filter.speed_variance)) if started else None,
        )
        before = self._force
        share = dt / (self._p.rolling.lag + dt)
        if acceleration is None or before is None:
            self._force = acceleration
        else:
            self._force = before + share * (acceleration - before)

    def _judged(
        self,
        stamp: int,
        measured: Sequence[SpeedSample],
        at_wheels: tuple[float, list[int]] | None,
        smooth_rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        gauged: bool,
    ) -> Sequence[SpeedSample]:
        """Return the samples of the sensor that may be used; `gauged`: there is an accelerometer."""
        sensor = self._sensor
        if self.mode is not Mode.WAITING:
            measured, begins_anew = sensor.take(stamp, measured, smooth_rim_speeds, gauged)
            if begins_anew:
                self.mode = Mode.WAITING
        started, variance = self.mode is not Mode.WAITING, self.stated_variance
        if gauged and started:
            votes = self._accelerometer.votes
            sensor.vote(votes, stamp, measured, smooth_rim_speeds, rim_accelerations, variance)
        return sensor.judge(measured, at_wheels, self._effort(), variance, started, gauged)

    def _change_mode(self, stamp: int, smooth_rim_speeds: Sequence[float], speed_at_wheels: bool) -> None:
        """Make the transition of this sample, and what comes with it."""
        before, slid = self.mode, self._is_sliding
        evidence = self._slide.evidence(self._sensor.speaks(stamp), speed_at_wheels)
        self.mode, cause = transition(before, evidence, self._p.slide)
        self._doubt_road(stamp)
        if cause is Cause.NONE:
            return
        self.cause, self._since = cause, stamp
        if self._is_sliding and not slid:
            self._slide.begin_slide()
            self._bounds.begin_slide()
        elif self.mode is Mode.ROLLING and before is Mode.SLIDING:
            self._return_to_wheels(smooth_rim_speeds, cause)

    @property
    def source(self) -> SpeedSource:
        """Where the speed comes from at the last sample."""
        return SOURCES[self.mode]

    @property
    def accelerometer_text(self) -> str:
        """Why the accelerometer is left out, empty where it is used."""
        return self._accelerometer.text

    @property
    def sensor_text(self) -> str:
        """Names what is wrong with the speed sensor, empty where nothing is."""
        return self._sensor.text

    @property
    def _is_sliding(self) -> bool:
        return self.mode in (Mode.WAITING, Mode.SLIDING, Mode.SENSOR_SLIDING)

    def health_values(self, stamp: int) -> dict[str, str]:
        """Texts for diagnostics at a stamp [ns], by name."""
        known, slide = self._filter, self._slide
        time_in_mode = (stamp - self._since) / NANOSECONDS if self._since is not None else 0.0
        return {
            "speed source": self.source.name.lower(),
            "mode": self.mode.name.lower(),
            "cause of the mode": self.cause.value,
            "time in mode [s]": f"{time_in_mode:.1f}",
            "wheel disagreement [m/s]": f"{slide.spread:.3f}",
            "vehicle speed [m/s]": f"{known.speed:.3f}",
            "vehicle speed standard deviation [m/s]": f"{sqrt(known.speed_variance):.3f}",
            "accelerometer offset [m/s^2]": f"{known.offset:.3f}",
            "accelerometer offset standard deviation [m/s^2]": f"{sqrt(known.offset_variance):.3f}",
        }

    def _at_wheels(self, rim_speeds: Sequence[float]) -> tuple[float, list[int]] | None:
        """Return the mean of the wheels that are believed [m/s] and which these are; None where they tell nothing."""
        wheels = [index for index in self._slide.believed() if isfinite(rim_speeds[index])]
        if not wheels:
            return None
        believed = [rim_speeds[index] for index in wheels]
        speed = sum(believed) / len(believed)
        blind = (
            abs(speed) < self._p.slide.blind_below
            and abs(self._slide.acceleration or 0.0) >= _AT_REST * self._offset_stddev
        )
        return None if blind else (speed, wheels)

    def _use_wheels(self, stamp: int, dt: float, at_wheels: tuple[float, list[int]] | None, starting: bool) -> None:
        if at_wheels is not None:
            speed, wheels = at_wheels
            self.radii.use(wheels)
            slip = (
                self._p.slip_per_acceleration
                * speed
                * min(abs(self._slide.acceleration or 0.0), self._p.rolling.forceless)
            )
            many = max(self._p.rolling.correlation / dt, 1.0)
            noise = (
                self._p.rolling.blind_stddev**2 * many
                if abs(speed) < self._p.slide.blind_below
                else self._rim_speed_variance / len(wheels)
            )
            variance = noise + slip**2 * many
            if starting:
                self._start_at_wheels(speed, variance, self._effort())
            else:
                self._not_yet_believed.append((stamp, speed, variance))
        late = self._p.rolling.lag * NANOSECONDS
        while self._not_yet_believed and stamp - self._not_yet_believed[0][0] >= late:
            when, speed, variance = self._not_yet_believed.popleft()
            effort = self._effort()
            if effort:
                variance += self._filter.slip_noise
            if self._filter.correct(speed, variance, when, effort):
                self._watch_offset(dt)

    def _start_at_wheels(self, speed: float, variance: float, effort: float) -> None:
        """Take the speed from wheels that slip by an effort, as far as that is known."""
        p = self._p.speed_filter
        slip = p.compliance_stddev * effort
        self._filter.start(speed * (1.0 + p.compliance * effort), variance + (slip * speed) ** 2)

    def _doubt_road(self, stamp: int) -> None:
        """Where wheels that turn alike and accelerometer differ for long, the road may have changed its slope."""
        mismatch = self._slide.slope.mismatch
        if not mismatch or (
            self._doubted is not None and stamp - self._doubted <= self._p.slope.settle_time * NANOSECONDS
        ):
            return
        self._doubted = stamp
        if self._is_sliding:
            self._filter.doubt_road(mismatch**2)
        else:
            # The difference is that over the window, and has lasted.
            ago = 0.5 * self._p.slide.window + self._p.slope.lasting
            self._filter.doubt_past_offset(mismatch**2, ago)

    def _effort(self) -> float:
        """Deceleration by which the tyres of the wheels that are believed slip [m/s^2]."""
        force, offset = self._slide.direction * (self._force or 0.0), self._slide.direction * self._filter.offset
        if force > 0.0 and self._slide.free_believed():
            return 0.0
        # On a slope that has been learned the corrected acceleration is that of the road: tyres need no slip for it.
        along = copysign(1.0, force) * (force - offset) + sqrt(self._filter.offset_variance)
        return -copysign(max(min(along, abs(force)) - self._p.rolling.forceless, 0.0), force)

    def _return_to_wheels(self, smooth_rim_speeds: Sequence[float], cause: Cause) -> None:
        """Take the speed from the wheels.

        The error of the integration is not attributed to the offset: lag and scale of the accelerometer may have caused
        it as well, and the next slide would begin with a wrong offset.
        """
        believed = [smooth_rim_speeds[index] for index in self._slide.believed()]
        if not believed:
            believed = [speed for speed in smooth_rim_speeds if isfinite(speed)]
        speed, effort = median(believed), self._effort()
        if cause is Cause.AGREED:
            self._filter.correct(speed, self._rim_speed_variance, None, effort)
        else:
            self._start_at_wheels(speed, self._rim_speed_variance, effort)
        if cause is Cause.AGAINST_ACCELEROMETER:
            self._filter.doubt_offset(self._offset_stddev**2)

    def _watch_offset(self, dt: float) -> None:
        """Learn the offset again when the innovations of the wheels stay on one side."""
        self._surprise += min(dt / self._p.rolling.surprise_time, 1.0) * (self._filter.surprise - self._surprise)
        if abs(self._surprise) > self._p.rolling.surprise:
            self._filter.doubt_offset(self._p.rolling.doubt**2)


def _of_car(parameters: AccelerometerParameters, vehicle: Vehicle) -> AccelerometerParameters:
    """Return the parameters with the deviation of the offset that the vehicle file states, if it is a larger one."""
    stated = deviation_of(vehicle.accelerometer.deviations, "bias", 0.0)
    return replace(parameters, bias_stddev=max(parameters.bias_stddev, stated))


def _gain_stddev(vehicle: Vehicle) -> float | None:
    """Deviation of the accelerometer's gain as a share, by scale and pitch; None where the vehicle file states none."""
    mounting = vehicle.accelerometer
    scale = specified_stddev(mounting.deviations, "scale")
    if scale is None:
        return None
    return hypot(scale / mounting.scale, GRAVITY * deviation_of(mounting.deviations, "pitch_gain", 0.0))
