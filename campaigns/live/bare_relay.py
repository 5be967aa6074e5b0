"""Node in rclpy alone that publishes what it receives: the baseline of friction_adapter.

python3 -m campaigns.live.bare_relay VEHICLE FROM TO
"""

import sys

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from friction_runtime import qos
from friction_runtime.spin import stop_on_signals, take_down
from vehicle_doctor.drive import IMU, WHEEL_STATES, kinds
from vehicle_models.vehicle_file import load_vehicle

_PERIOD = 0.2
"""Time between two looks at whether a signal has come [s]."""


def main(vehicle: str, source: str, target: str) -> None:
    """Relay joint states, IMU and pressures of a car from one namespace to another until a signal."""
    stop = stop_on_signals()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("bare_relay")
    for topic, kind in kinds(load_vehicle(vehicle)).items():
        if topic in (WHEEL_STATES, IMU) or topic.endswith("/brake_pressure"):
            publisher = node.create_publisher(kind, f"{target}/{topic}", qos.ESTIMATE)
            node.create_subscription(kind, f"{source}/{topic}", publisher.publish, qos.SENSOR)
    executor = EventsExecutor()
    executor.add_node(node)
    while not stop.is_set():
        executor.spin_until_future_complete(Future(), timeout_sec=_PERIOD)
    take_down(node, executor)


if __name__ == "__main__":
    main(*sys.argv[1:])
