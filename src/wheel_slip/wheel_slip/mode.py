"""Mode of the speed estimate: an explicit machine, a total function of mode and evidence.

In ROLLING the wheels correct the speed. In SLIDING the accelerometer is integrated and the wheels are bounds. A speed
sensor corrects in either. WAITING has no speed: no wheel is trusted before it has been seen to roll. One transition is
made at a sample; that of the sensor comes first.
"""

from enum import Enum
from typing import Final, NamedTuple

from wheel_slip.estimate import Mode
from wheel_slip.tuning import SlideTuning


class Cause(Enum):
    """Why a transition was made, in words."""

    NONE = ""
    STARTED = "start, reset, or no sample for a second"
    SENSOR = "a speed sensor has come"
    NO_SENSOR = "the speed sensor is silent, or contradicted"
    STRONG = "the acceleration is above slide_above"
    WHEELS_SLIDE = "wheels do not roll"
    AGREED = "the wheels have rolled and agree with the speed"
    CALM = "the wheels have rolled for long and the car hardly accelerates"
    PULLED = "free wheels have rolled while the engine pulls"
    STEADY = "the wheels turn alike and steadily"
    AGAINST_ACCELEROMETER = "the wheels turn alike and steadily, whatever the accelerometer reads"


_ROLLING: Final = {Mode.WAITING: Mode.ROLLING, Mode.SLIDING: Mode.ROLLING, Mode.SENSOR_SLIDING: Mode.SENSOR_ROLLING}
"""The mode after a slide."""
_SLIDING: Final = {Mode.ROLLING: Mode.SLIDING, Mode.SENSOR_ROLLING: Mode.SENSOR_SLIDING}
"""The mode in a slide."""
_WITH_SENSOR: Final = {
    Mode.WAITING: Mode.SENSOR_SLIDING,
    Mode.ROLLING: Mode.SENSOR_ROLLING,
    Mode.SLIDING: Mode.SENSOR_SLIDING,
}
_WITHOUT_SENSOR: Final = {Mode.SENSOR_ROLLING: Mode.ROLLING, Mode.SENSOR_SLIDING: Mode.SLIDING}


class Evidence(NamedTuple):
    """What one sample says of the mode."""

    sensor: bool
    """Whether a speed sensor has spoken lately and nothing contradicts it."""
    speed_at_wheels: bool
    """Whether the wheels that roll give a speed: one of them turns, or the car stands."""
    wheels_roll: bool
    """Whether enough of the wheels that are judged roll."""
    pulled: bool
    """Whether the engine pulls a car of which the free wheels are known: these alone are judged then."""
    acceleration: float
    """Size of the acceleration of the car [m/s^2], 0 where it is not known."""
    calm: bool
    """Whether neither brake nor engine has made the wheels slip for a while."""
    agree: bool
    """Whether the wheels agree with the speed, or there is none."""
    rolled: float
    """Time for which the wheels have rolled since the slide began [s]; negative where they do not."""
    steady: float
    """Time for which they have turned alike and hardly changed since then [s]; negative where they do not."""


def transition(mode: Mode, evidence: Evidence, parameters: SlideTuning) -> tuple[Mode, Cause]:
    """Return the next mode and the cause of the transition; the same mode and Cause.NONE where there is none."""
    if evidence.sensor and mode in _WITH_SENSOR:
        return _WITH_SENSOR[mode], Cause.SENSOR
    if not evidence.sensor and mode in _WITHOUT_SENSOR:
        return _WITHOUT_SENSOR[mode], Cause.NO_SENSOR
    if mode in _SLIDING:
        cause = _slides(evidence, parameters)
        return (mode if cause is Cause.NONE else _SLIDING[mode]), cause
    cause = Cause.NONE if mode is Mode.WAITING and not evidence.speed_at_wheels else _rolls(evidence, parameters)
    return (mode if cause is Cause.NONE else _ROLLING[mode]), cause


def _slides(evidence: Evidence, parameters: SlideTuning) -> Cause:
    """Return why wheels that were trusted are no longer: every wheel has slip in a strong acceleration."""
    if not evidence.pulled and evidence.acceleration > parameters.slide_above:
        return Cause.STRONG
    return Cause.NONE if evidence.wheels_roll else Cause.WHEELS_SLIDE


def _rolls(evidence: Evidence, parameters: SlideTuning) -> Cause:
    """Return why wheels are trusted again.

    Only the first cause looks at the integrated speed: one that has gone wrong must not keep the estimate.
    """
    if evidence.steady >= parameters.steady_time:
        return Cause.STEADY if evidence.wheels_roll else Cause.AGAINST_ACCELEROMETER
    if not evidence.wheels_roll or evidence.rolled < parameters.settle_time:
        return Cause.NONE
    if evidence.agree:
        return Cause.AGREED
    if evidence.pulled:
        return Cause.PULLED
    calm = evidence.calm and evidence.rolled >= parameters.calm_time
    return Cause.CALM if calm else Cause.NONE
