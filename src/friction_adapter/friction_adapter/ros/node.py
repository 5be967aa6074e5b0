"""Node friction_adapter: one processor for the car."""

from collections.abc import Sequence
from time import time_ns

from friction_adapter.map_file import load_map
from friction_adapter.parameters import FrictionAdapterParameters
from friction_adapter.ros.processor import AdapterProcessor, installed_fields
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.processor import Processor, Report
from friction_runtime.processor_node import Connect, ProcessorNode, subscribe_to_all
from friction_runtime.spin import run
from vehicle_models.vehicle import Vehicle


def build(parameters: FrictionAdapterParameters, _vehicle: Vehicle, report: Report) -> list[Processor]:
    """Make the processor.

    Raises:
        ParameterError: the map is not valid, or a message type in it is not installed.
    """
    signal_map = load_map(parameters.map_file, parameters.vehicle_file)
    for text in signal_map.cannot:
        report("warning", f"signal map {signal_map.path}: {text}")
    try:
        processor = AdapterProcessor(signal_map, installed_fields, report, arrival=time_ns, kind_of=message_class)
    except UnknownTypeError as error:
        raise ParameterError(str(error)) from error
    return [processor]


def make_node(connect: Connect = subscribe_to_all) -> ProcessorNode[FrictionAdapterParameters]:
    """Make the node, whose inputs come by `connect`; rclpy is initialised.

    Raises:
        ParameterError: a parameter, map or vehicle file is bad, or the map reads a topic that it makes.
    """
    node = ProcessorNode("friction_adapter", FrictionAdapterParameters, build, connect)
    own = sorted(set(node.sensors) & set(node.outputs))
    if own:
        raise ParameterError(f"the map reads {', '.join(own)}, which this node makes: remap it, or start it elsewhere")
    return node


def main(args: Sequence[str] | None = None) -> int:
    """Run until a signal; return the exit code."""
    return run("friction_adapter", FrictionAdapterParameters, make_node, args)
