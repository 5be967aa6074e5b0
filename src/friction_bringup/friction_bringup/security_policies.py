"""SROS2 policy file: permissions of each estimator's node.

The topics are those that the processors declare for the car at hand, so the file can neither lag behind the code nor
allow more than a node does.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, make_processors, read_parameters
from friction_bringup import graph
from friction_runtime.processor import silent
from smart_tyre_forces.ros.node import ZERO_REQUESTS
from vehicle_models.vehicle_file import load_vehicle

PUBLISHED = ("/diagnostics", "/rosout", "/parameter_events")
"""Topics that every node publishes beside its estimates."""
ANSWERED = (
    "~/reset",
    *("~/describe_parameters", "~/get_parameter_types", "~/get_parameters", "~/list_parameters"),
    *("~/set_parameters", "~/set_parameters_atomically", "~/get_type_description"),
)
"""Services of every node."""
OWN = {SMART_TYRE: tuple(f"~/{name}" for name in ZERO_REQUESTS)}
"""Further services, by node."""
_VERSION = "0.2.0"


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--vehicle", required=True, metavar="NAME|FILE", help="the car")
    parser.add_argument("--params-file", type=Path, action="append", default=[], help="ROS parameter file; repeatable")
    parser.add_argument("--namespace", default="/", help="namespace of the nodes, such as /car")
    parser.add_argument("--commanding", action="store_true", help="let abs_supervisor publish brake commands")
    parser.add_argument("--composed", action="store_true", help="one enclave for the estimators that share a process")


def run(options: Namespace) -> int:
    """Print the policies."""
    secured = options.vehicle, options.params_file, options.namespace, options.commanding, options.composed
    print(policies(*secured), end="")
    return 0


def policies(
    vehicle: str,
    files: Sequence[Path] = (),
    namespace: str = "/",
    commanding: bool = False,
    composed: bool = False,
) -> str:
    """Return the policies of all estimators.

    Args:
        vehicle: vehicle file: path, or name of a shipped one.
        files: ROS parameter files that override those of the packages.
        namespace: namespace of the nodes.
        commanding: whether abs_supervisor may publish brake commands. No other node may in any case.
        composed: whether the estimators share a process, which then has one enclave, named `estimators`.

    Raises:
        ParameterError: a parameter or the vehicle file is bad.
    """
    place = f"/{namespace.strip('/')}"
    parameters = read_parameters(ESTIMATORS, files, silent, place)
    parameters[graph.SUPERVISOR] = replace(parameters[graph.SUPERVISOR], shadow=not commanding)
    car = load_vehicle(vehicle)
    root = Element("policy", version=_VERSION)
    enclaves = SubElement(root, "enclaves")
    of_process: dict[str, Element] = {}
    for name, own in parameters.items():
        processors = make_processors({name: own}, car, silent)
        taken = {topic for each in processors for topic in (*each.sensors, *each.estimates)}
        given = {topic for each in processors for topic in each.outputs}
        process = graph.COMPOSED_PROCESS if composed and name in graph.COMPOSED else name
        if process not in of_process:
            enclave = SubElement(enclaves, "enclave", path=f"{place.rstrip('/')}/{process}")
            of_process[process] = SubElement(enclave, "profiles")
        profile = SubElement(of_process[process], "profile", ns=place, node=name)
        _allow(profile, "services", "reply", "service", (*ANSWERED, *OWN.get(name, ())))
        _allow(profile, "topics", "publish", "topic", (*sorted(given), *PUBLISHED))
        _allow(profile, "topics", "subscribe", "topic", sorted(taken))
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _allow(profile: Element, kinds: str, direction: str, kind: str, names: Iterable[str]) -> None:
    allowed = SubElement(profile, kinds, {direction: "ALLOW"})
    for name in names:
        SubElement(allowed, kind).text = name
