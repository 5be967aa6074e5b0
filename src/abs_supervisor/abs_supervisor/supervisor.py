"""The state machine in message time: time in the state, cause of the last transition, duration of failures."""

from dataclasses import dataclass
from math import isfinite, nan

from abs_supervisor.fsm import Cause, Inputs, State, Thresholds, transition
from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECOND


@dataclass
class Counts:
    """Transitions since start or reset."""

    transitions: int = 0
    instabilities: int = 0
    recoveries: int = 0
    release_timeouts: int = 0
    fail_safes: int = 0


class Evidence:
    """What is known at one stamp."""

    def __init__(self, h: float, indicator: float, usable: bool, slow: bool, braking: bool) -> None:
        """Hold what is known.

        Args:
            h: H of (8.3) [rad/s^3]; NaN where unknown, as for a locked wheel.
            indicator: H sign(eta) [rad/s^3]; 0 or NaN where the sign is not measured.
            usable: False where the indicator or the driver's demand is missing or not valid.
            slow: below the speed where the ABS ends.
            braking: whether the driver brakes.
        """
        self.h = h
        self.indicator = indicator
        self.usable = usable
        self.slow = slow
        self.braking = braking


class Supervisor:
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
        self.counts = Counts()
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

    def update(self, stamp: int, evidence: Evidence) -> bool:
        """Take what is known at a stamp [ns], later than the last; return whether there was a transition."""
        failed = self._unusable.update(stamp, not evidence.usable)
        if not evidence.usable and not failed:
            return False
        measured = isfinite(evidence.indicator) and evidence.indicator != 0.0
        inputs = Inputs(
            braking=evidence.braking,
            indicator=evidence.indicator if measured else nan,
            slip_growing=not evidence.indicator * evidence.h < 0.0,
            failed=failed,
            slow=evidence.slow,
        )
        in_state = (stamp - self.transition_stamp) * NANOSECOND
        state, cause = transition(self.state, inputs, in_state, self._thresholds)
        return self._enter(state, cause, stamp)

    def _enter(self, state: State, cause: Cause, stamp: int) -> bool:
        if state is self.state:
            return False
        self.previous_state, self.state, self.cause, self.transition_stamp = self.state, state, cause, stamp
        self.counts.transitions += 1
        self.counts.instabilities += cause is Cause.INSTABILITY
        self.counts.recoveries += cause is Cause.STABILITY
        self.counts.release_timeouts += cause is Cause.RELEASE_TIMEOUT
        self.counts.fail_safes += cause is Cause.FAIL_SAFE
        return True
