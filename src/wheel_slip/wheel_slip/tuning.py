"""Physical quantities of wheel_slip that a user does not set."""

from collections.abc import Sequence
from dataclasses import dataclass

from friction_parameters.parameter import constant


@dataclass(frozen=True)
class SlideTuning:
    """When a wheel, and the car, count as rolling."""

    window: float = constant(0.2, "window T over which wheels are compared with the accelerometer", unit="s")
    threshold: float = constant(0.15, "difference |D| over that window above which a wheel slides", unit="m/s")
    slide_above: float = constant(3.0, "acceleration above which wheels are not trusted", unit="m/s^2")
    roll_below: float = constant(2.5, "acceleration below which they may be trusted again", unit="m/s^2")
    settle_time: float = constant(0.3, "time for which wheels must roll before they are trusted again", unit="s")
    agreement: float = constant(0.02, "share by which wheels that agree with the speed may differ from it")
    agreement_at_rest: float = constant(
        0.1, "what they may differ by besides, and by the speed's deviation", unit="m/s"
    )
    calm_below: float = constant(
        1.0, "acceleration below which wheels that roll are trusted over the integrated speed", unit="m/s^2"
    )
    most_offset: float = constant(
        0.5, "offset of the accelerometer, beyond which its reading is a force of the tyres on any slope", unit="m/s^2"
    )
    calm_time: float = constant(1.0, "time for which they must roll before they are", unit="s")
    steady_below: float = constant(
        0.5,
        "change of rim speed below which wheels that turn alike are right, whatever the accelerometer reads",
        unit="m/s^2",
    )
    steady_time: float = constant(2.0, "time for which they must turn so", unit="s")
    spread: float = constant(0.03, "share by which rim speeds of rolling wheels may differ: radii, curves")
    spread_at_rest: float = constant(0.3, "what they may differ by besides: quantisation", unit="m/s")
    blind_below: float = constant(
        0.6, "rim speed below which an encoder reads zero, and a wheel may be locked", unit="m/s"
    )
    strongest: float = constant(
        14.0, "without an accelerometer: change of rim speed above which a wheel slides", unit="m/s^2"
    )

    def likeness(self, speed: float) -> float:
        """Return how far rim speeds of rolling wheels may be from each other at a speed [m/s]."""
        return self.spread_at_rest + self.spread * abs(speed)

    def are_alike(self, known: Sequence[float]) -> bool:
        """Whether wheels turn alike, as those that roll do, by their rim speeds in ascending order [m/s]."""
        return bool(known) and known[-1] - known[0] <= self.likeness(known[len(known) // 2])


@dataclass(frozen=True)
class SensorWatchTuning:
    """When a speed sensor is not believed, and how well its age is known."""

    sure: float = constant(5.0, "standard deviations beyond which it contradicts the wheels")
    time: float = constant(0.5, "time for which it must, and must not before it is used again", unit="s")
    frozen: float = constant(
        0.3,
        "change of speed by the accelerometer, beyond which a sample that repeats the last is an old one",
        unit="m/s",
    )
    latency_stddev: float = constant(
        0.07, "deviation of the age of its samples, until a change of the acceleration has shown it", unit="s"
    )


@dataclass(frozen=True)
class SlopeTuning:
    """When wheels and accelerometer differ by a slope of the road."""

    steepest: float = constant(1.5, "difference that a road makes at most: a slope of 15 %", unit="m/s^2")
    least: float = constant(0.4, "difference that noise does not make", unit="m/s^2")
    steady_slip: float = constant(0.08, "slip that may stay and looks like a slope")
    lasting: float = constant(0.2, "time for which the difference must last: a dive passes through all", unit="s")
    alike: float = constant(0.5, "time for which wheels turn alike when none has dived lately", unit="s")
    forceless: float = constant(
        0.6, "force of all tyres over the mass of the car, below which they have no slip to speak of", unit="m/s^2"
    )
    settle_time: float = constant(0.5, "time that a doubt of the offset needs to be settled", unit="s")


@dataclass(frozen=True)
class SpeedFilterTuning:
    """Noise of the accelerometer and of its offset."""

    offset_walk: float = constant(
        0.001,
        "change of the offset in the square root of a second while the wheels roll and the offset is learned",
        unit="m/s^2",
    )
    blind_offset_walk: float = constant(
        0.06,
        "the same while wheels that roll are braked, and a change of road slope looks like their slip",
        unit="m/s^2",
    )
    slope_stddev: float = constant(
        0.4, "change of the offset by the road's slope while the wheels slide and tell nothing of it", unit="m/s^2"
    )
    slope_length: float = constant(40.0, "way on which such a change comes and goes", unit="m")
    gain_stddev: float = constant(
        0.02, "deviation of the accelerometer's scale and of the pitch of the body, as a share of the acceleration"
    )
    delay_stddev: float = constant(
        0.2, "deviation of the accelerometer's age against the wheels, where the vehicle file states none", unit="s"
    )
    compliance: float = constant(0.008, "slip of a rolling wheel per acceleration of the car, to expect", unit="s^2/m")
    compliance_stddev: float = constant(0.05, "its standard deviation", unit="s^2/m")
    compliance_time: float = constant(5.0, "time in which it changes: the road, and how near the peak is", unit="s")
    telling: float = constant(
        0.7,
        "acceleration from which on it tells of gain and slip: less is noise, which looks like a gain of 0",
        unit="m/s^2",
    )
    acceleration_walk: float = constant(
        30.0,
        "without an accelerometer: change of the acceleration in the square root of a second, 10 m/s^2 in 0.1 s",
        unit="m/s^2",
    )
    unknown_acceleration: float = constant(
        5.0, "deviation of the acceleration when the accelerometer has just gone, or over a gap", unit="m/s^2"
    )


@dataclass(frozen=True)
class CarriedTuning:
    """When a wheel is carried by the road."""

    time: float = constant(
        0.03, "T: below the time a supervisor leaves a wheel released, above the half period of its swing", unit="s"
    )
    quiet: float = constant(
        2.0, "largest variance of a carried wheel's gap, over the noise: T at 200 Hz averages twelve samples"
    )
    swinging: float = constant(
        0.32, "deviation of the gap when a slide begins: no wheel counts as carried in the first 0.14 s", unit="m/s"
    )
    plausible: float = constant(3.0, "standard deviations by which a carried wheel may differ from the speed")
    released: float = constant(
        0.5,
        "time over which the slip of a carried wheel is one error: longer than a supervisor leaves it released",
        unit="s",
    )


@dataclass(frozen=True)
class ReleasedTuning:
    """When a wheel is released, and what it tells."""

    open_below: float = constant(
        40.0, "brake torque below which a brake is open: the offset of a pressure sensor", unit="N m"
    )
    gained: float = constant(
        0.01, "share of the car's speed by which a wheel comes back at least, or its brake was not what held it"
    )
    settles: float = constant(0.05, "time for which the brake must be open", unit="s")
    stands: float = constant(0.04, "time for which the wheel must keep its gap to the speed", unit="s")
    swings: float = constant(0.005, "share of the speed by which the gap may swing meanwhile")
    slip: float = constant(
        0.004, "slip that such a wheel may have: by drag of the engine, the rest of a torque, of its swing"
    )


@dataclass(frozen=True)
class BoundTuning:
    """How closely the wheels bound the speed in a slide."""

    margin: float = constant(0.02, "share of the speed by which wheels may pass the bound: radii, torsional vibration")
    latency: float = constant(
        0.03, "time by which wheel speeds may be older or younger than the acceleration", unit="s"
    )
    spring_back: float = constant(
        0.1,
        "time for which wheels must be beyond the bound: released tyres spring back and turn them faster than the car",
        unit="s",
    )
    close: float = constant(
        0.1, "slip below which a braked wheel confirms the speed: it slips by anything from 0 to that"
    )
    comes_again: float = constant(1.0, "time within which a wheel whose brake cycles is that close again", unit="s")
    effort_above: float = constant(
        1.0, "acceleration from which on it is known whether wheels are braked or driven", unit="m/s^2"
    )
    carried: CarriedTuning = CarriedTuning()
    released: ReleasedTuning = ReleasedTuning()


@dataclass(frozen=True)
class RollingTuning:
    """How the wheels are believed while the car rolls."""

    lag: float = constant(
        0.1, "a wheel sample is used this long after its stamp, where nothing has shown a slide", unit="s"
    )
    correlation: float = constant(0.1, "time over which the slip of a rolling wheel is one error, not many", unit="s")
    forceless: float = constant(
        0.3, "acceleration by drag and slope, for which tyres need no slip to speak of", unit="m/s^2"
    )
    blind_stddev: float = constant(0.1, "standard deviation of the speed where encoders read zero", unit="m/s")
    surprise: float = constant(
        0.6, "mean innovation over its deviation that noise does not reach in hours: the offset has changed"
    )
    surprise_time: float = constant(0.2, "time over which that innovation is averaged", unit="s")
    doubt: float = constant(0.05, "standard deviation of the offset after such a change", unit="m/s^2")


@dataclass(frozen=True)
class Tuning:
    """Which source is trusted when, and how much."""

    slip_per_acceleration: float = constant(
        0.004, "uncertainty of a rolling wheel's slip per acceleration of the car", unit="s^2/m"
    )
    radius_uncertainty: float = constant(
        0.002, "uncertainty of all radii together, as a share: speed from wheels is no better"
    )
    forget_after: float = constant(1.0, "time without any sample after which the estimate starts again", unit="s")
    speed_filter: SpeedFilterTuning = SpeedFilterTuning()
    slide: SlideTuning = SlideTuning()
    sensor: SensorWatchTuning = SensorWatchTuning()
    slope: SlopeTuning = SlopeTuning()
    rolling: RollingTuning = RollingTuning()
    bounds: BoundTuning = BoundTuning()
