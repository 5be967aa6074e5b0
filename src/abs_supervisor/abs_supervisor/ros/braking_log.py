"""Log of a braking: one line when it is over, and each failure of the inputs."""

from abs_supervisor.state_machine import Cause, State, StateMachine
from friction_runtime.processor import Report
from friction_runtime.reports import of_wheel
from vehicle_models.nanoseconds import NANOSECONDS


class BrakingLog:
    """Follows the transitions of one wheel. Single transitions go to DEBUG: a stop has hundreds."""

    def __init__(self, wheel: str, report: Report) -> None:
        """Choose the wheel."""
        self._wheel = wheel
        self._report = report
        self.reset()

    def reset(self) -> None:
        """Forget a braking that is under way."""
        self._begun = 0
        self._releases_before = 0

    def note(self, machine: StateMachine, stamp: int, reason: str) -> None:
        """Take a transition that `machine` has just made.

        Args:
            machine: the state machine of the wheel.
            stamp: newest stamp of the braking [ns]: that of the transition, or the last before a jump back in time.
            reason: why the inputs cannot be used, empty where they can.
        """
        cause = machine.cause.name.lower()
        seconds = machine.transition_stamp / NANOSECONDS
        change = f"{machine.previous_state.name} -> {machine.state.name} at {seconds:.3f} s, cause {cause}"
        self._report("debug", f"{self._wheel}: {change}")
        if machine.previous_state is State.S0:
            self._begun, self._releases_before = stamp, machine.counts.instabilities
        elif machine.state is State.S0:
            releases = machine.counts.instabilities - self._releases_before
            self._report(
                "info",
                f"{self._wheel}: braked for {(stamp - self._begun) / NANOSECONDS:.2f} s, "
                f"releases: {releases}, last cause: {cause}",
            )
        if machine.cause is Cause.FAIL_SAFE:
            self._report("error", of_wheel(self._wheel, f"{reason}: fail-safe"))
