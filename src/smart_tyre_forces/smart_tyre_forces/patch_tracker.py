"""From the two sampled signals to one contact patch per revolution, streaming (section 8.4.4).

The passages are the same for blocks of any size, bit for bit: a revolution is processed only when its last crossing has
come, and then from samples chosen by angle, never by block.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_parameters.parameter import constants, minimum_speed_parameter, parameter
from smart_tyre_forces.encoder_crossings import CrossingParameters, EncoderCrossings
from smart_tyre_forces.front_template import FrontRefiner
from smart_tyre_forces.fronts import FREE_BEGIN, FREE_END, WINDOW_END, find_fronts, noise_over_slope
from smart_tyre_forces.sample_buffer import SampleBuffer
from smart_tyre_forces.tooth_table import ToothTable
from smart_tyre_forces.wheel_angle import WheelAngle
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Wheel

Array = NDArray[np.float64]

_ACQUISITION_WIDTH = np.radians(20.0)
"""Width of the running mean whose minimum is the patch [rad]."""
_DEEP: Final = 0.4
"""Share of the median over the revolution below which that minimum counts as the patch."""
_LENGTHS = np.radians((8.0, 50.0))
"""Plausible contact patch lengths [rad]."""
_FAILURES: Final = 3
"""Passages without fronts after which the patch is searched for again."""
_HIGHEST_VOLTAGE: Final = 1e4
"""Highest voltage of an encoder [V]: what is beyond it is garbage."""
_HIGHEST_ACCELERATION: Final = 1e7
"""Highest acceleration in a tyre [m/s^2], far beyond where any sensor saturates."""
_BUFFER: Final = 60_000
"""Samples kept at least: a wheel slower than one revolution in 6 s has no angle anyway."""


@dataclass(frozen=True)
class TrackerParameters:
    """The sensors of a wheel, and the speeds at which they show the contact patch."""

    sample_rate: float = parameter(1.0e4, "rate of the tyre signals", unit="Hz", minimum=5e3, maximum=1e5)
    minimum_speed: float = minimum_speed_parameter(3.0)
    maximum_speed: float = parameter(
        35.0, "no estimate above this vehicle speed", unit="m/s", minimum=5.0, maximum=100.0
    )
    acceleration_range: float = parameter(
        500.0 * 9.81, "saturation of the accelerometer", unit="m/s^2", minimum=100.0, maximum=1e5
    )
    crossings: CrossingParameters = constants(CrossingParameters())

    def __post_init__(self) -> None:
        """Refuse an empty range of speeds."""
        if not self.maximum_speed > self.minimum_speed:
            raise ValueError("parameter 'maximum_speed' must exceed 'minimum_speed'")


@dataclass(frozen=True)
class Passage:
    """One passage of the accelerometer through the contact patch."""

    revolution: int
    """Number of the revolution since the start."""
    time: float
    """Time of the trailing front, or of the end of an invalid revolution [samples since index 0]."""
    alpha_1: float
    """Leading front [rad], tooth table frame, 0 to 2 pi (its centre); NaN when not OK."""
    alpha_2: float
    """Trailing front [rad]."""
    wheel_speed: float
    """Mean over the window of the passage [rad/s]; NaN where unknown."""
    reason: Reason
    reference: int
    """Convention of zero angle: angles of different references cannot be compared."""
    front_stddev: float = np.nan
    """Standard deviation of either front from the noise of the signal [rad]; NaN when not OK."""

    @property
    def length(self) -> float:
        """Length of the contact patch [rad], Delta phi = alpha_2 - alpha_1 (8.13)."""
        return self.alpha_2 - self.alpha_1

    @property
    def centre(self) -> float:
        """Angle of its centre [rad], delta phi = (alpha_1 + alpha_2) / 2 (8.15), before any zero is set."""
        return 0.5 * (self.alpha_1 + self.alpha_2)


class PatchTracker:
    """Passages of one wheel."""

    def __init__(
        self,
        wheel: Wheel,
        parameters: TrackerParameters = TrackerParameters(),
        table: ToothTable | None = None,
        refiner: FrontRefiner | None = None,
    ) -> None:
        """Start; without a tooth table it is learned first, without a refiner fronts are crossings."""
        self._radius = wheel.radius
        self._parameters = parameters
        self._crossings = EncoderCrossings(parameters.sample_rate, parameters.crossings)
        self.wheel = WheelAngle(wheel.encoder_teeth, table)
        """Angle of the wheel over time."""
        self._refiner = refiner
        self._acceleration = SampleBuffer(0)
        self._next: int | None = None
        self._revolution = 0
        self._centre: float | None = None
        self._failures = 0

    def push(
        self, first_sample: int, voltage: NDArray[np.floating], acceleration: NDArray[np.floating]
    ) -> list[Passage]:
        """Take a block and return the passages it completes.

        Args:
            first_sample: index of its first sample; a jump means lost packets.
            voltage: voltage of the encoder [V], shape (n,).
            acceleration: radial acceleration [m/s^2], shape (n,); NaN where it is missing. What no sensor gives counts
                as missing.

        Raises:
            ValueError: the two differ in length, or the block is empty.
        """
        if voltage.shape != acceleration.shape or voltage.ndim != 1 or len(voltage) == 0:
            raise ValueError(f"block: {voltage.shape} encoder and {acceleration.shape} acceleration samples")
        passages: list[Passage] = []
        if self._next is not None and first_sample != self._next:
            passages += self._interrupt(Reason.GAP, first_sample)
        if self._next is None or first_sample != self._next:
            self._restart(first_sample)
        self._next = first_sample + len(voltage)
        if np.count_nonzero(np.abs(voltage) <= _HIGHEST_VOLTAGE) < len(voltage):
            passages += self._interrupt(Reason.BAD_INPUT, first_sample)
            self._restart(self._next)
            return passages
        measured = np.abs(acceleration) <= _HIGHEST_ACCELERATION
        complete = np.count_nonzero(measured) == len(measured)
        self._acceleration.append(acceleration if complete else np.where(measured, acceleration, np.nan))
        for stretch in self._crossings.push(np.asarray(voltage, dtype=np.float64)):
            if stretch.interrupted is not None:
                passages += self._interrupt(stretch.interrupted, int(stretch.times[0]))
                self.wheel.restart()
                self._centre = None
            self.wheel.extend(stretch.times)
            passages += self._revolutions()
        if passages:
            self._trim()
        if len(self._acceleration) > 2 * _BUFFER:
            self._acceleration.drop_before(self._acceleration.next - _BUFFER)
        return passages

    def _restart(self, sample: int) -> None:
        self._crossings.restart(sample)
        self.wheel.restart()
        self._acceleration = SampleBuffer(sample)
        self._centre = None

    def _interrupt(self, reason: Reason, sample: int) -> list[Passage]:
        """Return, once, an invalid passage with the reason why the angle is lost."""
        if not self.wheel.known:
            return []
        return [self._invalid(reason, float(sample), np.nan)]

    def _invalid(self, reason: Reason, time: float, wheel_speed: float) -> Passage:
        self._revolution += 1
        return Passage(self._revolution, time, np.nan, np.nan, wheel_speed, reason, self.wheel.reference)

    def _revolutions(self) -> list[Passage]:
        passages: list[Passage] = []
        while self.wheel.known:
            angles = self.wheel.angles
            if len(angles) == 0:
                break
            if self._centre is None:
                if angles[-1] - angles[0] < 2.5 * np.pi:
                    break
                found = self._acquire(float(angles[0]))
                if found is None:
                    passages.append(self._no_patch())
                    continue
                self._centre = found
                self._failures = 0
            elif angles[-1] < self._centre + WINDOW_END:
                break
            else:
                passages.append(self._passage(self._centre))
        return passages

    def _samples(self, begin: float, end: float) -> tuple[Array, Array]:
        """Return times [samples] and acceleration of the samples between two angles [rad]."""
        first, last = np.ceil(self.wheel.time_of(begin)), np.floor(self.wheel.time_of(end))
        times = np.arange(first, last + 1.0)
        return times, self._acceleration.get(int(first), len(times))

    def _acquire(self, begin: float) -> float | None:
        """Return the centre of the next patch [rad], from the revolution that starts at angle `begin`."""
        times, acceleration = self._samples(begin, begin + 2.25 * np.pi)
        width = max(int(len(times) * _ACQUISITION_WIDTH / (2.25 * np.pi)), 2)
        total = np.concatenate(((0.0,), np.cumsum(acceleration)))
        mean = (total[width:] - total[:-width]) / width
        if not np.all(np.isfinite(mean)):
            return None
        lowest = int(np.argmin(mean))
        if not mean[lowest] < _DEEP * np.median(mean):
            return None
        centre = float(self.wheel.at(times[lowest] + np.array([0.5 * (width - 1)]))[0])
        while centre + FREE_BEGIN < begin:
            centre += 2.0 * np.pi
        return centre

    def _no_patch(self) -> Passage:
        """Skip a revolution in which no patch was found."""
        begin = float(self.wheel.angles[0])
        end = self.wheel.time_of(begin + 2.0 * np.pi)
        start = self.wheel.time_of(begin)
        speed = self._rate(2.0 * np.pi, end - start)
        self.wheel.forget_before(end)
        reason = self._speed_reason(speed)
        return self._invalid(Reason.NO_FRONTS if reason is Reason.OK else reason, end, speed)

    def _rate(self, angle: float, samples: float) -> float:
        return angle * self._parameters.sample_rate / samples

    def _speed_reason(self, wheel_speed: float) -> Reason:
        speed = wheel_speed * self._radius
        inside = self._parameters.minimum_speed <= speed <= self._parameters.maximum_speed
        return Reason.OK if inside else Reason.SPEED_RANGE

    def _passage(self, centre: float) -> Passage:
        wheel = self.wheel
        begin, free_end, end = (wheel.time_of(centre + a) for a in (FREE_BEGIN, FREE_END, WINDOW_END))
        free_speed = self._rate(FREE_END - FREE_BEGIN, free_end - begin)
        speed = self._rate(WINDOW_END - FREE_END, end - free_end)
        self._centre = centre + 2.0 * np.pi
        reason = self._speed_reason(speed)
        if reason is not Reason.OK:
            return self._invalid(reason, end, speed)
        times, acceleration = self._samples(centre + FREE_BEGIN, centre + WINDOW_END)
        if not np.all(np.isfinite(acceleration)):
            return self._invalid(Reason.BAD_INPUT, end, speed)
        split = int(np.searchsorted(times, free_end))
        if np.max(np.abs(acceleration)) >= 0.999 * self._parameters.acceleration_range:
            return self._invalid(Reason.SATURATED, end, speed)
        theta = wheel.at(times) - centre
        fronts = find_fronts(
            theta[split:], acceleration[split:], float(np.mean(acceleration[:split])), speed / free_speed
        )
        if fronts is not None and not _LENGTHS[0] < fronts.alpha_2 - fronts.alpha_1 < _LENGTHS[1]:
            fronts = None
        if fronts is not None:
            fronts = replace(fronts, stddev=noise_over_slope(theta, acceleration, fronts))
        if fronts is not None and self._refiner is not None:
            fronts = self._refiner.refine(fronts, theta, acceleration)
        if fronts is None:
            self._failures += 1
            if self._failures >= _FAILURES:
                self._centre = None
                wheel.forget_before(end)
            return self._invalid(Reason.NO_FRONTS, end, speed)
        self._failures = 0
        self._centre += 0.5 * (fronts.alpha_1 + fronts.alpha_2)
        self._revolution += 1
        turns = 2.0 * np.pi * np.floor((centre + 0.5 * (fronts.alpha_1 + fronts.alpha_2)) / (2.0 * np.pi))
        return Passage(
            revolution=self._revolution,
            time=wheel.time_of(centre + fronts.alpha_2),
            alpha_1=centre + fronts.alpha_1 - turns,
            alpha_2=centre + fronts.alpha_2 - turns,
            wheel_speed=speed,
            reason=Reason.OK,
            reference=wheel.reference,
            front_stddev=fronts.stddev,
        )

    def _trim(self) -> None:
        """Keep what the coming revolution needs."""
        if self.wheel.known and len(self.wheel.times):
            if self._centre is not None:
                self.wheel.forget_before(self.wheel.time_of(self._centre + FREE_BEGIN))
            self._acceleration.drop_before(int(self.wheel.times[0]) - 1)
