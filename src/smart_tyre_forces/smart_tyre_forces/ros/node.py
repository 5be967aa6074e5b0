"""Node smart_tyre_forces: one processor per wheel, and the services that request a new zero."""

from collections.abc import Callable, Sequence

from std_srvs.srv import Trigger

from friction_runtime.processor import Report
from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.ros.processor import TyreProcessor, build
from vehicle_models.vehicle import Vehicle

ZERO_REQUESTS = {"zero_shift": TyreProcessor.request_shift_zero, "zero_length": TyreProcessor.request_length_zero}
"""Services of this node below its own name, and what each asks of every tyre."""


class SmartTyreNode(ProcessorNode[SmartTyreParameters]):
    """The shared node with `~/zero_shift` and `~/zero_length` (std_srvs/Trigger)."""

    def __init__(self, connect: Connect) -> None:
        """Make the node, whose inputs come by `connect`; rclpy is initialised."""
        self._tyres: list[TyreProcessor] = []
        super().__init__("smart_tyre_forces", SmartTyreParameters, self._remember, connect)
        for name, request in ZERO_REQUESTS.items():
            self._serve(name, request)

    def _remember(self, parameters: SmartTyreParameters, vehicle: Vehicle, report: Report) -> list[TyreProcessor]:
        self._tyres = build(parameters, vehicle, report)
        return self._tyres

    def _serve(self, name: str, request: Callable[[TyreProcessor], None]) -> None:
        def on_call(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            for tyre in self._tyres:
                request(tyre)
            response.success = True
            response.message = f"{name}: at the next stretch of constant speed"
            self.get_logger().info(response.message)
            return response

        self.create_service(Trigger, f"~/{name}", on_call)


def make_node(connect: Connect = subscribe_to_all) -> SmartTyreNode:
    """Make the node, whose inputs come by `connect`; rclpy is initialised."""
    return SmartTyreNode(connect)


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run("smart_tyre_forces", SmartTyreParameters, make_node, args)
