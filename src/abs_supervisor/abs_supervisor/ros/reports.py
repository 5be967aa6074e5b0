"""Reports of one wheel: its state as messages and for diagnostics, and a log of each braking."""

from friction_msgs.msg import SupervisorDebug, SupervisorState
from std_msgs.msg import Header

from abs_supervisor.state_machine import Cause, State, StateMachine
from abs_supervisor.wheel_supervisor import WheelSupervisor
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import Report
from friction_runtime.reports import of_wheel
from vehicle_models.nanoseconds import NANOSECONDS


def state_messages(
    header: Header, machine: StateMachine, supervisor: WheelSupervisor
) -> tuple[SupervisorState, SupervisorDebug]:
    """Return state and internals under a header, whose frame is the wheel."""
    intervention, slip, controller = supervisor.intervention, supervisor.slip, supervisor.controller
    state = SupervisorState(header=header, wheel=header.frame_id)
    state.state, state.previous_state, state.cause = int(machine.state), int(machine.previous_state), int(machine.cause)
    state.transition_stamp = from_nanoseconds(machine.transition_stamp)
    state.law, state.law_cause = int(supervisor.law), int(supervisor.arbitration.cause)
    state.slip, state.slip_set_point = supervisor.measured.slip, controller.slip_set_point
    state.intervention, state.budget = int(intervention.phase), intervention.budget
    state.release, state.limit = int(intervention.release), int(intervention.limit)
    state.refused_releases = intervention.refused
    state.degraded = supervisor.degraded
    state.unchecked = supervisor.unchecked
    counts = machine.counts
    debug = SupervisorDebug(header=header, wheel=header.frame_id)
    debug.release_slip, debug.wheel_deceleration = slip.release_slip, slip.deceleration
    debug.road_torque = intervention.road_torque
    debug.torque_set_point, debug.disturbance_torque = controller.torque_set_point, supervisor.disturbance
    debug.transitions, debug.instabilities = counts.total(), counts[Cause.INSTABILITY]
    debug.recoveries, debug.release_timeouts = counts[Cause.STABILITY], counts[Cause.RELEASE_TIMEOUT]
    debug.fail_safes, debug.limited_releases = counts[Cause.FAIL_SAFE], intervention.limited
    return state, debug


def diagnostic_values(machine: StateMachine, supervisor: WheelSupervisor) -> dict[str, str]:
    """Return what the diagnostics of a wheel show."""
    counts, intervention = machine.counts, supervisor.intervention
    return {
        "state": machine.state.name,
        "cause of the last transition": machine.cause.name.lower(),
        "transitions": str(counts.total()),
        "instabilities": str(counts[Cause.INSTABILITY]),
        "recoveries": str(counts[Cause.STABILITY]),
        "release time-outs": str(counts[Cause.RELEASE_TIMEOUT]),
        "fail-safes": str(counts[Cause.FAIL_SAFE]),
        "intervention": intervention.phase.name,
        "refused releases": str(intervention.refused),
        "limited releases": str(intervention.limited),
        "unchecked": supervisor.unchecked,
    }


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
            self._begun, self._releases_before = stamp, machine.counts[Cause.INSTABILITY]
        elif machine.state is State.S0:
            releases = machine.counts[Cause.INSTABILITY] - self._releases_before
            self._report(
                "info",
                f"{self._wheel}: braked for {(stamp - self._begun) / NANOSECONDS:.2f} s, "
                f"releases: {releases}, last cause: {cause}",
            )
        if machine.cause is Cause.FAIL_SAFE:
            self._report("error", of_wheel(self._wheel, f"{reason}: fail-safe"))
