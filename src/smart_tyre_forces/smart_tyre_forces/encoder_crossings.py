"""Zero crossings of the encoder's sine, streaming: the same for blocks of any size, bit for bit (section 8.4.4).

Every sample of the sine takes part: a short symmetric filter (its delay is a whole number of samples) averages the
neighbourhood of each crossing before the crossing is interpolated, on a sine. Hysteresis keeps noise from adding
crossings, so they alternate between rising and falling and lie 180/teeth degrees apart. Across missing teeth they are
put in again (see missing_teeth).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_parameters.parameter import constant
from smart_tyre_forces.fir import filtered
from smart_tyre_forces.missing_teeth import Gap
from vehicle_models.reason import Reason

Array = NDArray[np.float64]

_HANN: Final = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, 7))
_TAPS = _HANN[1:-1] / np.sum(_HANN)
_DELAY = (len(_TAPS) - 1) // 2
_LONGEST_INTERVAL: Final = 0.033
"""Time between crossings [s] above which the wheel may have turned back: the sine has no direction."""
_LATE: Final = 1.25
"""Ratio of neighbouring intervals from which a crossing waits for what follows: a tooth may be missing."""
_QUIET: Final = 0.5
"""Share of an interval with the sine within the hysteresis, from which there was no tooth: 0.3 at walking pace."""


@dataclass(frozen=True)
class CrossingParameters:
    """What counts as a crossing."""

    hysteresis: float = constant(
        0.1, "voltage to be passed on either side of a zero crossing; a smaller sine counts as standstill", unit="V"
    )
    interval_ratio: float = constant(
        1.5, "ratio of neighbouring crossing intervals below the inverse of which one is surplus"
    )


@dataclass(frozen=True)
class Stretch:
    """Crossings with nothing missed between them."""

    interrupted: Reason | None
    """Why the angle was lost before the first of these; None when they continue the crossings before."""
    times: Array
    """[samples since index 0], increasing."""


class EncoderCrossings:
    """Finds the crossings of one encoder."""

    def __init__(self, sample_rate: float, parameters: CrossingParameters = CrossingParameters()) -> None:
        """Start without history, at a sample rate [Hz]."""
        self._parameters = parameters
        self._longest_interval = round(_LONGEST_INTERVAL * sample_rate)
        self.restart(0)

    def restart(self, sample: int) -> None:
        """Forget everything; the next voltage is that of index `sample`."""
        self._next = sample
        self._carried: Array = np.zeros(0)
        self._armed: tuple[float, float] | None = None
        self._previous: list[float] = []
        self._gap: Gap | None = None
        self._last_chord = np.nan

    def push(self, voltage: Array) -> list[Stretch]:
        """Take the next samples [V], finite, shape (n,); return the crossings they complete, in faultless stretches."""
        known = np.concatenate((self._carried, voltage))
        first = self._next - len(self._carried) + _DELAY
        self._next += len(voltage)
        self._carried = known[1 - len(_TAPS) :]
        if len(known) < len(_TAPS):
            return []
        smooth = filtered(_TAPS, known)
        armed = (np.abs(smooth) >= self._parameters.hysteresis).nonzero()[0]
        if len(armed) == 0:
            return []
        carried = 0 if self._armed is None else 1
        places, values = np.empty((2, carried + len(armed)))
        places[carried:] = armed + float(first)
        values[carried:] = smooth[armed]
        if self._armed is not None:
            places[0], values[0] = self._armed
        self._armed = (float(places[-1]), float(values[-1]))
        positive = values > 0.0
        change = (positive[1:] != positive[:-1]).nonzero()[0]
        if len(change) == 0:
            return []
        after = change + 1
        return self._checked(*self._between(places[change], places[after], values[change], values[after]))

    def _between(self, begin: Array, end: Array, before: Array, after: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Times of the zeros between samples of opposite sign, first on the chord, then on the sine; which are vague.

        The last half wave gives the phase delta between the two samples, and A sin(x) = |before|, A sin(delta - x) =
        |after| give the phase x at which the zero lies, whatever the amplitude A.
        """
        before, after = np.abs(before), np.abs(after)
        step = end - begin
        chord = begin + step * (before / (before + after))
        last = np.empty(len(chord))
        last[0], last[1:] = self._last_chord, chord[:-1]
        self._last_chord = float(chord[-1])
        interval = chord - last
        delta = np.minimum(np.pi * step / interval, 2.0)
        phase = np.arctan2(before * np.sin(delta), after + before * np.cos(delta))
        return np.where(np.isfinite(delta), begin + step * phase / delta, chord), step > _QUIET * interval

    def _checked(self, times: Array, vague: NDArray[np.bool_]) -> list[Stretch]:
        if self._gap is not None or np.count_nonzero(vague):
            return self._one_by_one(times.tolist(), vague.tolist())
        carried = len(self._previous)
        known = np.empty(carried + len(times))
        known[:carried], known[carried:] = self._previous, times
        intervals = known[1:] - known[:-1]
        ratio = intervals[1:] / intervals[:-1]
        uneven = (ratio > _LATE) | (ratio * self._parameters.interval_ratio < 1.0)
        if np.count_nonzero(uneven) or np.count_nonzero(intervals > self._longest_interval):
            return self._one_by_one(times.tolist(), vague.tolist())
        self._previous = known[-2:].tolist()
        return [Stretch(None, times)]

    def _one_by_one(self, times: list[float], vague: list[bool]) -> list[Stretch]:
        """The same where an interval is not like the one before."""
        stretches: list[Stretch] = []
        interrupted: Reason | None = None
        good: list[float] = []
        for time, is_vague in zip(times, vague, strict=True):
            fault = self._take(time, is_vague, good)
            if fault is not None:
                if good:
                    stretches.append(Stretch(interrupted, np.asarray(good)))
                interrupted, good = fault, [time]
                self._previous, self._gap = [time], None
        if good:
            stretches.append(Stretch(interrupted, np.asarray(good)))
        return stretches

    def _take(self, time: float, vague: bool, good: list[float]) -> Reason | None:
        """Take one crossing; append to `good` what is known by it, or return why the angle is lost."""
        previous = self._previous
        newest = self._gap.newest if self._gap is not None else previous[-1] if previous else time
        if time - newest > self._longest_interval:
            return Reason.REVERSAL
        found = [time]
        if self._gap is not None:
            bridged = self._gap.bridge(time)
            if bridged is None:
                return None if self._gap.may_be_bridged else Reason.MISSED_TOOTH
            found, self._gap = bridged, None
        elif len(previous) == 2:
            interval = previous[1] - previous[0]
            ratio = (time - newest) / interval
            if vague or ratio > _LATE:
                self._gap = Gap(previous[1], interval, time, _LATE)
                return None
            if ratio * self._parameters.interval_ratio < 1.0:
                return Reason.MISSED_TOOTH
        good += found
        self._previous = [*previous, *found][-2:]
        return None
