"""The finite state machine of Figure 8.1: a total function of state, input and time in the state, in message time.

    S0 --demand >= T-bar--> S1 --indicator <= H_inst--> S21 --n ms--> S22 --indicator >= H_st--> S1

and from S1, S21, S22 back to S0 when braking is over, when the inputs fail or at low speed. S22 also returns to S1 when
it has released for long enough: a slope that stays unmeasurable must not keep the brake open.

The peak is crossed upwards only while slip grows and downwards only while it falls. So S1 is left for indicators that
were measured with growing slip, and S22 for those with falling slip. Otherwise a wheel that recovers from beyond the
peak, to which a release time-out has given pressure again, would at once be released again.
"""

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum
from math import isfinite, nan
from typing import NamedTuple

from friction_parameters.parameter import parameter
from friction_runtime.filters import Debounce
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECOND


class State(IntEnum):
    """States; the values are those of friction_msgs/SupervisorState."""

    S0 = 0
    S1 = 1
    S21 = 2
    S22 = 3


class Cause(IntEnum):
    """Why a transition was made; the values are those of friction_msgs/SupervisorState."""

    NONE = 0
    BRAKING = 1
    INSTABILITY = 2
    WAIT_OVER = 3
    STABILITY = 4
    RELEASE_TIMEOUT = 5
    BRAKING_OVER = 6
    FAIL_SAFE = 7
    RESET = 8
    LOW_SPEED = 9


COMMANDS = {
    State.S0: Command.NONE,
    State.S1: Command.INCREASE,
    State.S21: Command.DECREASE,
    State.S22: Command.DECREASE,
}
"""Control action of each state, section 8.2.2."""


@dataclass(frozen=True)
class Thresholds:
    """Thresholds and times of the transitions."""

    h_instability: float = parameter(
        -1.0,
        "H_inst: stability is lost where the indicator is at or below it",
        unit="rad/s^3",
        minimum=-1e5,
        maximum=-1e-3,
        read_only=True,
    )
    h_stability: float = parameter(
        8000.0,
        "H_st: stability is regained where the indicator is at or above it",
        unit="rad/s^3",
        minimum=1e-3,
        maximum=1e6,
        read_only=True,
    )
    wait: float = parameter(
        0.035, "n: least time in S21, for the release to act", unit="s", minimum=0.0, maximum=1.0, read_only=True
    )
    release_timeout: float = parameter(
        0.165, "longest time in S22", unit="s", minimum=0.005, maximum=10.0, read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse thresholds of the wrong sign."""
        if not self.h_instability < 0.0 < self.h_stability:
            raise ValueError(
                f"h_instability ({self.h_instability}) must be < 0 and h_stability ({self.h_stability}) > 0"
            )
        if not (self.wait >= 0.0 and self.release_timeout > 0.0):
            raise ValueError(f"wait ({self.wait}) must be >= 0 and release_timeout ({self.release_timeout}) > 0")


class Inputs(NamedTuple):
    """Inputs of the machine at one sample."""

    braking: bool
    """The driver demands at least T-bar."""
    indicator: float
    """H sign(eta) of (8.5) [rad/s^3]; NaN where the sign is not measured."""
    slip_growing: bool
    """The sign that entered the indicator: true for sign(eta) > 0."""
    failed: bool = False
    """Inputs stale or invalid."""
    slow: bool = False
    """Below the speed where the ABS ends."""


def transition(state: State, inputs: Inputs, time_in_state: float, thresholds: Thresholds) -> tuple[State, Cause]:
    """Return the next state and the cause of the transition; the same state and Cause.NONE when there is none.

    Args:
        state: present state.
        inputs: inputs at this sample. An indicator that is not measured (NaN) makes no transition.
        time_in_state: time since the state was entered [s], >= 0.
        thresholds: thresholds of the transitions.
    """
    if state is State.S0:
        if inputs.braking and not inputs.failed and not inputs.slow:
            return State.S1, Cause.BRAKING
        return State.S0, Cause.NONE
    if inputs.failed:
        return State.S0, Cause.FAIL_SAFE
    if not inputs.braking:
        return State.S0, Cause.BRAKING_OVER
    if inputs.slow:
        return State.S0, Cause.LOW_SPEED
    if state is State.S21:
        return (State.S22, Cause.WAIT_OVER) if time_in_state >= thresholds.wait else (state, Cause.NONE)
    if state is State.S1:
        if inputs.slip_growing and inputs.indicator <= thresholds.h_instability:
            return State.S21, Cause.INSTABILITY
        return state, Cause.NONE
    if not inputs.slip_growing and inputs.indicator >= thresholds.h_stability:
        return State.S1, Cause.STABILITY
    if time_in_state >= thresholds.release_timeout:
        return State.S1, Cause.RELEASE_TIMEOUT
    return state, Cause.NONE


class StateMachine:
    """State machine of one wheel. `update` makes at most one transition per sample."""

    def __init__(self, thresholds: Thresholds, tolerance: float) -> None:
        """Start in S0.

        Args:
            thresholds: thresholds of the transitions.
            tolerance: inputs that are not usable for longer [s] bring the fail-safe; until then the state is kept.
        """
        self._thresholds = thresholds
        self._unusable = Debounce(round(tolerance / NANOSECOND))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.state = State.S0
        self.previous_state = State.S0
        self.cause = Cause.NONE
        """Cause of the last transition."""
        self.counts: Counter[Cause] = Counter()
        """Transitions since start or reset, by their cause."""
        self.transition_stamp = 0
        """Stamp of the last transition [ns]; 0 before the first."""
        self._unusable.reset()

    def restart(self, stamp: int) -> bool:
        """Go to S0 and keep the counts, as after a jump back in time; return whether that was a transition."""
        self._unusable.reset()
        return self._enter(State.S0, Cause.RESET, stamp)

    def fail(self, stamp: int) -> bool:
        """Go to S0 because the inputs have fallen silent; return whether that was a transition."""
        return self._enter(State.S0, Cause.FAIL_SAFE, stamp)

    def update(
        self, stamp: int, h: float, indicator: float, braking: bool, usable: bool = True, slow: bool = False
    ) -> bool:
        """Take a sample; return whether there was a transition.

        Args:
            stamp: [ns], later than the last.
            h: H of (8.3) [rad/s^3]; NaN where unknown, as for a locked wheel.
            indicator: H sign(eta) [rad/s^3]; 0 or NaN where the sign is not measured.
            braking: whether the driver brakes.
            usable: False where the indicator or the driver's demand is missing or not valid.
            slow: below the speed where the ABS ends.
        """
        failed = self._unusable.update(stamp, not usable)
        if not usable and not failed:
            return False
        measured = indicator if isfinite(indicator) and indicator != 0.0 else nan
        inputs = Inputs(braking, measured, not indicator * h < 0.0, failed, slow)
        in_state = (stamp - self.transition_stamp) * NANOSECOND
        state, cause = transition(self.state, inputs, in_state, self._thresholds)
        return self._enter(state, cause, stamp)

    def _enter(self, state: State, cause: Cause, stamp: int) -> bool:
        if state is self.state:
            return False
        self.previous_state, self.state, self.cause, self.transition_stamp = self.state, state, cause, stamp
        self.counts[cause] += 1
        return True
