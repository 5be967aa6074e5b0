"""Command line: ``python3 -m friction_bringup demo``, ``graph``, ``monitor`` and ``policies``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from friction_adapter.map_argument import add_map_argument
from friction_adapter.map_file import load_map
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_vehicle import vehicle_for
from friction_bags.mapped.mapped_bag import MappedBag
from friction_bags.mapped.write_mapped import write_mapped
from friction_bags.offline.plan import SayOnce
from friction_bringup import graph
from friction_bringup.composed import run_composed
from friction_bringup.demo import run_demo
from friction_bringup.demo_drive import CARS, ROADS
from friction_bringup.demo_graph import DemoError, DemoOptions
from friction_bringup.monitor import run_monitor
from friction_bringup.security_policies import policies
from friction_parameters.command_line import command
from friction_parameters.parameter import ParameterError
from friction_report.recorded_run import require_samples
from friction_runtime.processor import silent
from friction_runtime.shipped_files import shipped_file
from vehicle_models.vehicle_file import add_vehicle_argument


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line and run; return the exit code: 1 where the demo failed, 2 for bad input."""
    return command(lambda: _run(arguments), BagError)


def _run(arguments: Sequence[str] | None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m friction_bringup", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("monitor", help="watch every wheel of a running graph; q quits; takes --ros-args")
    commands.add_parser("graph", help=f"run {', '.join(graph.COMPOSED)} in one process; takes --ros-args")
    demo = commands.add_parser(
        "demo", help="drive a car and brake it with the supervisor in the loop, or replay a bag, with a live view"
    )
    demo.add_argument("--surface", choices=ROADS, default="dry", help="road of the plant (default: dry)")
    demo.add_argument("--car", choices=CARS, default="car", help="a whole car, or the corner of the chapter")
    demo.add_argument(
        "--law", choices=graph.LAWS, default=graph.LAWS[0], help="what commands the brake (default: curve)"
    )
    demo.add_argument("--bag", type=Path, help="replay this bag in place of the plant")
    add_map_argument(demo)
    add_vehicle_argument(demo, "that of --car, or the one the bag names")
    demo.add_argument(
        "--params", type=Path, help="parameter file (default: that of the demo, or the one the bag names)"
    )
    demo.add_argument("--out", type=Path, default=Path("out"), help="directory for the results (default: out)")
    secure = commands.add_parser(
        "policies", help="print what each node may publish and read, as a policy file of SROS2"
    )
    secure.add_argument("--vehicle", required=True, metavar="NAME|FILE", help="the car")
    secure.add_argument("--params-file", type=Path, action="append", default=[], help="ROS parameter file; repeatable")
    secure.add_argument("--namespace", default="/", help="namespace of the nodes, such as /car")
    secure.add_argument("--commanding", action="store_true", help="let abs_supervisor publish brake commands")
    secure.add_argument("--composed", action="store_true", help="one enclave for the estimators that share a process")
    given = list(sys.argv[1:] if arguments is None else arguments)
    at = given.index("--ros-args") if "--ros-args" in given else len(given)
    options, of_ros = parser.parse_args(given[:at]), given[at:]
    if options.command == "graph":
        return run_composed(of_ros)
    if options.command == "monitor":
        return run_monitor(of_ros)
    if of_ros:
        parser.error(f"unrecognized arguments: {' '.join(of_ros)}")
    if options.command == "policies":
        secured = options.vehicle, options.params_file, options.namespace, options.commanding, options.composed
        print(policies(*secured), end="")
        return 0
    try:
        with _mapped(options) as native:
            return run_demo(_demo_options(native))
    except DemoError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


@contextmanager
def _mapped(options: argparse.Namespace) -> Iterator[argparse.Namespace]:
    """Yield options whose bag holds the topics of this graph: where a signal map is given, what it makes of the bag.

    Raises:
        ParameterError: the map is not valid, or there is no bag for it.
        BagError: the bag cannot be read, or lacks a topic of the map.
    """
    if not options.map:
        yield options
        return
    if not options.bag:
        raise ParameterError("--map is for a bag: give --bag")
    signal_map = load_map(options.map, options.vehicle)
    with TemporaryDirectory(prefix="friction_demo_") as directory:
        native = Path(directory, options.bag.resolve().stem)
        with MappedBag(options.bag, signal_map, SayOnce()) as bag:
            write_mapped(bag, native, signal_map.notes)
        yield argparse.Namespace(**{**vars(options), "bag": native})


def _demo_options(options: argparse.Namespace) -> DemoOptions:
    """Complete the command line from the notes of the bag.

    Raises:
        ParameterError: neither the bag nor the command line names the car.
        BagError: the bag cannot be read, or holds no wheel_states.
    """
    vehicle, parameters = options.vehicle or CARS[options.car], "demo"
    if options.bag:
        with BagReader(options.bag) as reader:
            require_samples(reader)
            vehicle = vehicle_for(reader, options.vehicle, "", silent)
            parameters = reader.custom_data.get("parameters", parameters)
    params = options.params or shipped_file("friction_bringup", parameters)
    return DemoOptions(options.surface, options.law, options.bag, vehicle, params.absolute(), options.out)


def demo_main() -> int:
    """``ros2 run friction_bringup demo ...``."""
    return main(["demo", *sys.argv[1:]])


def monitor_main() -> int:
    """``ros2 run friction_bringup monitor --ros-args ...``."""
    return main(["monitor", *sys.argv[1:]])


def graph_main() -> int:
    """``ros2 run friction_bringup graph --ros-args ...``."""
    return main(["graph", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
