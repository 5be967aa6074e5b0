"""Mode of the speed estimate: an explicit machine, a total function of mode and evidence.

In ROLLING the wheels correct the speed. In SLIDING the accelerometer is integrated and the wheels are bounds. A speed
sensor corrects in either. WAITING has no speed: no wheel is trusted before it has been seen to roll. One transition is
made at a sample; that of the sensor comes first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

from friction_parameters.parameter import parameter
from wheel_slip.estimate import Mode


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


@dataclass(frozen=True)
class SlideParameters:
    """When a wheel, and the car, count as rolling."""

    window: float = parameter(
        0.2, "window T over which wheels are compared with the accelerometer", unit="s", minimum=0.02, maximum=1.0
    )
    threshold: float = parameter(
        0.15, "difference |D| over that window above which a wheel slides", unit="m/s", minimum=0.01, maximum=5.0
    )
    slide_above: float = parameter(
        3.0, "acceleration above which wheels are not trusted", unit="m/s^2", minimum=0.1, maximum=20.0
    )
    roll_below: float = parameter(
        2.5, "acceleration below which they may be trusted again", unit="m/s^2", minimum=0.1, maximum=20.0
    )
    settle_time: float = parameter(
        0.3, "time for which wheels must roll before they are trusted again", unit="s", minimum=0.0, maximum=10.0
    )
    agreement: float = parameter(
        0.02, "share by which wheels that agree with the speed may differ from it", minimum=0.0, maximum=0.5
    )
    agreement_at_rest: float = parameter(
        0.1, "what they may differ by besides, and by the speed's deviation", unit="m/s", minimum=0.0, maximum=5.0
    )
    calm_below: float = parameter(
        1.0,
        "acceleration below which wheels that roll are trusted over the integrated speed",
        unit="m/s^2",
        minimum=0.1,
        maximum=20.0,
    )
    most_offset: float = parameter(
        0.5,
        "offset of the accelerometer, beyond which its reading is a force of the tyres on any slope",
        unit="m/s^2",
        minimum=0.0,
        maximum=5.0,
    )
    calm_time: float = parameter(
        1.0, "time for which they must roll before they are", unit="s", minimum=0.0, maximum=100.0
    )
    steady_below: float = parameter(
        0.5,
        "change of rim speed below which wheels that turn alike are right, whatever the accelerometer reads",
        unit="m/s^2",
        minimum=0.01,
        maximum=5.0,
    )
    steady_time: float = parameter(2.0, "time for which they must turn so", unit="s", minimum=0.1, maximum=100.0)
    spread: float = parameter(
        0.03, "share by which rim speeds of rolling wheels may differ: radii, curves", minimum=0.0, maximum=0.5
    )
    spread_at_rest: float = parameter(
        0.3, "what they may differ by besides: quantisation", unit="m/s", minimum=0.0, maximum=5.0
    )
    blind_below: float = parameter(
        0.6,
        "rim speed below which an encoder reads zero, and a wheel may be locked",
        unit="m/s",
        minimum=0.0,
        maximum=5.0,
    )
    strongest: float = parameter(
        14.0,
        "without an accelerometer: change of rim speed above which a wheel slides",
        unit="m/s^2",
        minimum=1.0,
        maximum=100.0,
    )

    def __post_init__(self) -> None:
        """Refuse thresholds in the wrong order."""
        if self.roll_below > self.slide_above:
            raise ValueError(f"parameter 'roll_below' = {self.roll_below} must not exceed 'slide_above'")

    def likeness(self, speed: float) -> float:
        """Return how far rim speeds of rolling wheels may be from each other at a speed [m/s]."""
        return self.spread_at_rest + self.spread * abs(speed)

    def are_alike(self, known: Sequence[float]) -> bool:
        """Whether wheels turn alike, as those that roll do, by their rim speeds in ascending order [m/s]."""
        return bool(known) and known[-1] - known[0] <= self.likeness(known[len(known) // 2])


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


def transition(mode: Mode, evidence: Evidence, parameters: SlideParameters) -> tuple[Mode, Cause]:
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


def _slides(evidence: Evidence, parameters: SlideParameters) -> Cause:
    """Return why wheels that were trusted are no longer: every wheel has slip in a strong acceleration."""
    if not evidence.pulled and evidence.acceleration > parameters.slide_above:
        return Cause.STRONG
    return Cause.NONE if evidence.wheels_roll else Cause.WHEELS_SLIDE


def _rolls(evidence: Evidence, parameters: SlideParameters) -> Cause:
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
