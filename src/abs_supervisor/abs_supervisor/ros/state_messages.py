"""State of the supervisor of one wheel as messages."""

from friction_msgs.msg import SupervisorDebug, SupervisorState
from std_msgs.msg import Header

from abs_supervisor.state_machine import StateMachine
from abs_supervisor.wheel_supervisor import WheelSupervisor
from friction_runtime.messages import from_nanoseconds


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
    debug.transitions, debug.instabilities = counts.transitions, counts.instabilities
    debug.recoveries, debug.release_timeouts = counts.recoveries, counts.release_timeouts
    debug.fail_safes, debug.limited_releases = counts.fail_safes, intervention.limited
    return state, debug
