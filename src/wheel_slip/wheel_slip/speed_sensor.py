"""Processing of the speed sensor: comparison with wheels and accelerometer, validation, use.

It owns what is known of the sensor (sensor_watch.py, sensor_age.py, sensor_skew.py) and changes the speed by it.
"""

from collections.abc import Sequence
from math import isfinite, sqrt
from statistics import median

from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.outvoted import Outvoted
from wheel_slip.radius_doubt import RadiusDoubt
from wheel_slip.sensor_watch import SensorWatch
from wheel_slip.slide_detector import SlideDetector
from wheel_slip.speed_filter import SpeedFilter
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.tuning import Tuning


class SpeedSensor:
    """The speed sensor of one car."""

    def __init__(
        self, tuning: Tuning, timeout: float, car: SpeedFilter, slide: SlideDetector, radii: RadiusDoubt
    ) -> None:
        """Start without samples.

        Args:
            tuning: of the speed.
            timeout: silence after which the wheels take over [s].
            car: the speed, which is corrected.
            slide: which wheels roll.
            radii: how far the radii make wheels wrong.
        """
        self._p = tuning
        self._timeout = timeout * NANOSECONDS
        self._car = car
        self._slide = slide
        self._radii = radii
        self._watch = SensorWatch(tuning.sensor)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._watch.reset()
        self._stamp: int | None = None
        self._used: int | None = None

    @property
    def text(self) -> str:
        """Names what is wrong with the sensor, empty where nothing is."""
        return self._watch.text

    @property
    def undecided_variance(self) -> float:
        """Variance of the speed by what sensor and wheels differ by, and nothing decides which is right [m^2/s^2]."""
        return 0.0 if self._watch.late else self._watch.undecided**2

    @property
    def age_variance(self) -> float:
        """Variance of a speed of the sensor by its age [m^2/s^2]."""
        return self._skew_variance + self._watch.age.error**2

    @property
    def _skew_variance(self) -> float:
        return self._watch.skew.variance(self._slide.acceleration)

    def speaks(self, stamp: int) -> bool:
        """Whether a sample has come lately, and nothing is wrong with the sensor."""
        return self._is_fresh(stamp) and not self._watch.left_out

    def _is_fresh(self, stamp: int) -> bool:
        return self._stamp is not None and stamp - self._stamp <= self._timeout

    def follow(self, stamp: int) -> None:
        """Follow the accelerometer up to a stamp [ns]."""
        self._watch.skew.follow(stamp, self._car.travelled_at(stamp) or 0.0)

    def take(
        self, stamp: int, measured: Sequence[SpeedSample], smooth_rim_speeds: Sequence[float], gauged: bool
    ) -> tuple[Sequence[SpeedSample], bool]:
        """Learn the age of samples.

        Args:
            stamp: of the wheels [ns].
            measured: the samples.
            smooth_rim_speeds: filtered rim speeds [m/s], NaN where unknown.
            gauged: whether there is an accelerometer.

        Returns:
            The samples that repeat no old one, and whether the speed must begin anew: it was made by old ones.
        """
        if not measured:
            return measured, False
        car, age, before = self._car, self._watch.age, self._watch.age.late
        travelled = [car.travelled_at(each.stamp) if gauged else None for each in measured]
        new = [
            each
            for each, so_far in zip(measured, travelled, strict=True)
            if not self._watch.is_old(each, so_far, car.offset)
        ]
        if gauged:
            self._learn_skew(new)
        begins_anew = False
        free = sorted([smooth_rim_speeds[index] for index in self._slide.free])
        if len(free) > 1 and self._p.slide.are_alike(free):
            speed = sum(free) / len(free)
            for sample in measured:
                change = car.change_since(sample.stamp)
                if change is not None:
                    age.update(sample.stamp, sample.speed + change - speed, speed, sample.variance)
            if age.late and not before and self._is_fresh(stamp):
                car.reset()
                self._watch.skew.start_again()
                self._stamp = None
                begins_anew = True
        return new, begins_anew

    def _learn_skew(self, measured: Sequence[SpeedSample]) -> None:
        """Compare samples with the accelerometer; where that shows that they are old, take away what they have done."""
        skew = self._watch.skew
        for sample in measured:
            was_late = skew.late
            skew.update(sample.stamp, sample.speed, sample.variance)
            if skew.late and not was_late:
                self._car.correct_course(*skew.motion())

    def judge(
        self,
        measured: Sequence[SpeedSample],
        at_wheels: tuple[float, list[int]] | None,
        effort: float,
        variance: float,
        started: bool,
        gauged: bool,
    ) -> Sequence[SpeedSample]:
        """Return the samples that may be used.

        Args:
            measured: the samples.
            at_wheels: speed by the wheels that are believed [m/s] and which these are; None where they tell nothing.
            effort: deceleration by which these slip [m/s^2].
            variance: of the speed, as it is stated [m^2/s^2].
            started: whether there is a speed.
            gauged: whether there is an accelerometer.
        """
        usable = self._fitting(measured, at_wheels, effort, variance, gauged) if measured and started else measured
        if self._watch.late:
            usable = ()
        if usable:
            self._stamp = usable[-1].stamp
        return usable

    def _fitting(
        self,
        measured: Sequence[SpeedSample],
        at_wheels: tuple[float, list[int]] | None,
        effort: float,
        variance: float,
        gauged: bool,
    ) -> Sequence[SpeedSample]:
        car, watch, radii = self._car, self._watch, self._radii
        usable: list[SpeedSample] = []
        for sample in measured:
            change = car.change_since(sample.stamp)
            if change is None:
                continue
            noise = sample.variance + self._skew_variance
            if at_wheels is not None and gauged and self._slide.has_rolled:
                rolling = at_wheels[0] * (1.0 + self._p.speed_filter.compliance * effort)
                shares = radii.common**2 + radii.of_mean + self._p.radius_uncertainty**2
                deviation = sqrt(shares * rolling**2 + self._p.rolling.blind_stddev**2 + noise)
                slip = abs(self._p.speed_filter.compliance_stddev * effort * rolling)
                fits = watch.compare(sample.stamp, sample.speed + change - rolling, deviation, slip)
            else:
                of_both = sqrt(noise + variance)
                fits = watch.fits(sample.stamp, sample.speed + change - car.speed, of_both)
            if fits:
                usable.append(sample)
        return usable

    def vote(
        self,
        votes: Outvoted,
        stamp: int,
        measured: Sequence[SpeedSample],
        smooth_rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        variance: float,
    ) -> None:
        """Compare samples with the speed and with wheels that turn alike, and say so to those who count the votes.

        Args:
            votes: against the accelerometer.
            stamp: of the wheels [ns].
            measured: the samples.
            smooth_rim_speeds: filtered rim speeds [m/s], NaN where unknown.
            rim_accelerations: their rates [m/s^2].
            variance: of the speed, as it is stated [m^2/s^2].
        """
        if not measured or self._watch.late:
            return
        car = self._car
        known = [index for index, speed in enumerate(smooth_rim_speeds) if isfinite(speed)]
        alike = self._p.slide.are_alike(sorted([smooth_rim_speeds[index] for index in known]))
        middle = median([smooth_rim_speeds[index] for index in known]) if alike else 0.0
        rate = median([rim_accelerations[index] for index in known]) if alike else 0.0
        of_age = self._skew_variance
        of_radii = (self._radii.common**2 + self._p.radius_uncertainty**2) * middle**2
        for sample in measured:
            change = car.change_since(sample.stamp)
            if change is None:
                continue
            then = middle - rate * (stamp - sample.stamp) / NANOSECONDS
            at_wheels = (sample.speed - then, of_radii + of_age) if alike else None
            at_speed = (sample.speed + change - car.speed, variance + of_age)
            votes.note(sample.stamp, sample.variance, at_speed, at_wheels)

    def use(self, sample: SpeedSample, starting: bool) -> None:
        """Correct the speed by a sample, or start it."""
        if starting:
            self._car.start(sample.speed, sample.variance, 0.0)
        else:
            # Over a short time an age is one error, as the slip of a rolling wheel is.
            since = (sample.stamp - self._used) / NANOSECONDS if self._used is not None else 0.0
            many = max(self._p.rolling.correlation / since, 1.0) if since > 0.0 else 1.0
            of_age = many * self._watch.skew.spread if self._slide.acceleration is not None else 0.0
            self._car.correct(sample.speed, sample.variance + of_age, sample.stamp, by_wheels=0.0)
        self._used = sample.stamp
