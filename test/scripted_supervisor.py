"""A supervisor of one wheel as a process, which releases and applies by the clock of the samples alone.

What stands between the plant and a supervisor that is killed or stopped is shown with it on any machine: the real one
gives the brake back to the driver whenever the machine is too slow for its fail-safe.
"""

from __future__ import annotations

import sys

import rclpy
from friction_msgs.msg import BrakeCommand
from sensor_msgs.msg import JointState

from friction_runtime import qos
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import to_nanoseconds

WHEEL = "front_left"
VALID_FOR = 0.9
"""[s] longer than a busy machine needs for an answer, shorter than what waits for a process that was stopped."""
_HALF_CYCLE = 500_000_000
"""[ns] of release, and of application."""


def main(counted: int) -> None:
    """Answer each sample until the process is ended; `counted` commands have gone before."""
    rclpy.init()
    node = rclpy.create_node("abs_supervisor")
    publisher = qos.publish(node, BrakeCommand, f"{WHEEL}/brake_command", qos.command(VALID_FOR))
    counter = counted

    def answer(message: JointState) -> None:
        nonlocal counter
        counter += 1
        releases = to_nanoseconds(message.header.stamp) // _HALF_CYCLE % 2
        command = BrakeCommand.DECREASE if releases else BrakeCommand.INCREASE
        publisher.publish(
            sealed(
                BrakeCommand(header=message.header, wheel=WHEEL, command=command, counter=counter, valid_for=VALID_FOR)
            )
        )

    qos.subscribe(node, JointState, "wheel_states", answer, qos.SENSOR)
    rclpy.spin(node)


if __name__ == "__main__":
    main(int(sys.argv[1]))
