"""Processors of a bag, their parameters and their division into stages."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from sensor_msgs.msg import JointState

from friction_adapter.map_file import load_map
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode, type_name
from friction_bags.bag_vehicle import vehicle_for
from friction_bags.offline.estimators import (
    SMART_TYRE,
    STATE,
    WHEEL_ESTIMATORS,
    make_processors,
    read_parameters,
    vehicle_of,
)
from friction_bags.remapped_bag import RemappedBag
from friction_parameters.parameter import from_mapping, values_of
from friction_runtime.installed import shipped_parameters
from friction_runtime.processor import Processor, Report, Severity
from friction_runtime.reports import report_kind
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

Stage = tuple[Processor, ...]
_WHEEL_STATES = "wheel_states"
_IMU = "imu/data"
_TYRE_SIGNALS, _PRESSURE = "/tyre_signals", "/brake_pressure"
_CURVES = "friction_curve_id"
_MOST_REPORTS = 100


def graph_stages(processors: Sequence[Processor], most: int) -> list[Stage]:
    """Divide processors into at most `most` stages that take about the same time.

    Processors for several wheels (wheel_slip) are in the first stage, which also reads the bag and so has fewer of the
    others. The others stay with those whose topics they take. A processor that collects the answers of several wheels
    (friction_state) is in the last stage.
    """
    collecting = [processor for processor in processors if _collects(processor, processors)]
    shared = [each for each in processors if len(_wheels(each)) > 1 and each not in collecting]
    groups = _connected([processor for processor in processors if processor not in (*shared, *collecting)])
    count = min(most, len(groups))
    alone = [processor for group in groups for processor in group]
    if count < 2 or _made(alone) & _needed(shared):
        return [tuple(processors)]
    inner = [max(stage, (len(groups) + 1) * stage // count - 1) for stage in range(1, count)]
    shares = [groups[begin:end] for begin, end in pairwise([0, *inner, len(groups)])]
    stages = [tuple(processor for group in share for processor in group) for share in shares]
    stages[-1] += tuple(collecting)
    return [(*shared, *stages[0]), *stages[1:]]


def _connected(processors: Sequence[Processor]) -> list[list[Processor]]:
    """Return groups of processors that take each other's topics."""
    groups: list[list[Processor]] = []
    for processor in processors:
        made, needed = _made([processor]), _needed([processor])
        joined = [group for group in groups if _made(group) & needed or made & _needed(group)]
        groups = [group for group in groups if group not in joined]
        groups.append([*(member for group in joined for member in group), processor])
    return groups


def _collects(processor: Processor, processors: Sequence[Processor]) -> bool:
    """Return whether a processor takes what is made for several wheels, and makes what nobody takes."""
    taken = _needed([processor]) & _made(processors)
    return len({topic.rpartition("/")[0] for topic in taken}) > 1 and not _made([processor]) & _needed(processors)


def _made(processors: Iterable[Processor]) -> set[str]:
    return {topic for processor in processors for topic in processor.outputs}


def _needed(processors: Iterable[Processor]) -> set[str]:
    return {topic for each in processors for topics in (each.sensors, each.estimates) for topic in topics}


def _wheels(processor: Processor) -> set[str]:
    return {topic.rpartition("/")[0] for topic in processor.outputs}


@dataclass(frozen=True)
class ProcessOptions:
    """Options of the user."""

    estimators: tuple[str, ...] = ()
    """Names of estimators; empty for all whose inputs the bag has."""
    vehicle: str = ""
    """Vehicle file or name of a shipped one; empty for that of the bag's note, or of the parameter files."""
    parameter_files: tuple[Path, ...] = ()
    """ROS parameter files that override those of the packages."""
    namespace: str = "/"
    """Namespace of the topics, e.g. /car; / for none."""
    outputs_only: bool = False
    """Whether to leave out the topics of the bag."""
    map_file: str = ""
    """Signal map, or name of a shipped one; empty where the bag holds the topics of this graph."""

    @property
    def prefix(self) -> str:
        """Prefix of the names of the topics."""
        return self.namespace.rstrip("/") + "/"


@dataclass(frozen=True)
class OfflinePlan:
    """What is done with the topics of one bag."""

    bag: Path
    parameters: Mapping[str, Mapping[str, Any]]
    """Values by estimator and dotted name: compiled dataclasses cannot be sent to a process."""
    vehicle: Vehicle
    vehicle_note: str
    """Name of the car in the note of the new bag."""
    taken: tuple[str, ...]
    """Relative name of each topic in the bag that the estimators take, empty for the other topics."""
    copied: tuple[bool, ...]
    """Whether each topic in the bag is copied to the new one."""
    map_file: str = ""
    """Signal map, as in ProcessOptions."""
    prefix: str = "/"
    """Prefix of the names of the topics."""

    def open_bag(self, report: Report) -> BagReader:
        """Open the bag again, in another process.

        Raises:
            BagError: it cannot be read.
        """
        return open_bag(self.bag, self.map_file, self.vehicle_note, self.prefix, report)

    def processors(self, report: Report) -> list[Processor]:
        """Make the processors.

        Raises:
            ParameterError: parameters do not fit the car.
        """
        parameters = {
            name: from_mapping(type(shipped_parameters(name)), each) for name, each in self.parameters.items()
        }
        return make_processors(parameters, self.vehicle, report)


class SayOnce:
    """Log function of processors: prints warnings and errors, each kind once."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(self, severity: Severity, text: str) -> None:
        """Print the text if its kind has not been printed before."""
        kind = report_kind(text)
        if severity in ("warning", "error") and kind not in self._said and len(self._said) < _MOST_REPORTS:
            self._said.add(kind)
            print(f"{severity}: {text}", file=sys.stderr)


def open_bag(bag: Path, map_file: str, vehicle: str, prefix: str, report: Report) -> BagReader:
    """Open a bag, through a signal map where one is given.

    Args:
        bag: bag to read.
        map_file: signal map, or name of a shipped one; empty for none.
        vehicle: vehicle file in place of that of the map; empty for that of the map.
        prefix: prefix of the names of the topics.
        report: log function.

    Raises:
        BagError: the bag cannot be read, or lacks a topic of the map.
        ParameterError: the map is not valid.
    """
    if not map_file:
        return BagReader(bag)
    return RemappedBag(bag, load_map(map_file, vehicle), report, prefix)


def plan_for(reader: BagReader, options: ProcessOptions, report: Report) -> tuple[OfflinePlan, list[Processor]]:
    """Make the plan for a bag; return also its processors.

    Raises:
        BagError: the bag holds no wheel of the car.
        ParameterError: a parameter or the vehicle file is bad, or no car is named.
    """
    prefix = options.prefix
    names = [topic.name.removeprefix(prefix) for topic in reader.counts]
    estimators = options.estimators
    if not estimators:
        has_tyres = any(name.endswith(_TYRE_SIGNALS) for name in names)
        of_wheels, collecting = (WHEEL_ESTIMATORS, (STATE,)) if _WHEEL_STATES in names else ((), ())
        estimators = (*of_wheels, *((SMART_TYRE,) if has_tyres else ()), *collecting)
    parameters = read_parameters(estimators, options.parameter_files, report, options.namespace)
    if _CURVES in parameters and _IMU in names and not any(name.endswith(_PRESSURE) for name in names):
        given, parameters[_CURVES] = parameters[_CURVES], parameters[_CURVES].without_pressure()
        if parameters[_CURVES] != given:
            report("warning", f"no brake pressure: {_CURVES} fits one curve for the car, by method 'vehicle'")
    note = vehicle_for(reader, options.vehicle, vehicle_of(parameters), report)
    vehicle = load_vehicle(note)
    _refuse_strange_car(reader, prefix, vehicle)
    processors = make_processors(parameters, vehicle, report)
    made = {topic for processor in processors for topic in processor.outputs}
    taken = _taken(reader, processors, made, prefix)
    _name_missing(processors, made.union(taken), prefix)
    copied = tuple(not options.outputs_only and name not in made for name in names)
    values = {name: values_of(each) for name, each in parameters.items()}
    plan = OfflinePlan(reader.bag, values, vehicle, note, tuple(taken), copied, options.map_file, prefix)
    return plan, processors


def output_numbers(processors: Sequence[Processor]) -> dict[str, int]:
    """Return numbers of the topics that processors make, in the order in which outputs of one message are written."""
    topics = dict.fromkeys(topic for processor in processors for topic in processor.outputs)
    return {topic: number for number, topic in enumerate(topics)}


def _taken(reader: BagReader, processors: Sequence[Processor], made: set[str], prefix: str) -> list[str]:
    """Return relative names of the bag's topics that processors take and none of them makes, empty for the others."""
    kinds: dict[str, Any] = {}
    for processor in processors:
        kinds.update(processor.sensors)
        kinds.update(processor.estimates)
    taken = []
    for topic in reader.counts:
        name = topic.name.removeprefix(prefix)
        fits = name in kinds and name not in made
        if fits and type_name(kinds[name]) != topic.type:
            print(f"warning: {topic.name} is {topic.type}, not {type_name(kinds[name])}: ignored", file=sys.stderr)
            fits = False
        taken.append(name if fits else "")
    return taken


def _name_missing(processors: Sequence[Processor], there: set[str], prefix: str) -> None:
    """Print which messages of other nodes are missing.

    What they are missing from may not even answer. The lack of a sensor is in the reasons of the estimates instead.
    """
    needed = dict.fromkeys(topic for each in processors for topic in each.estimates if topic not in each.optional)
    missing = [f"{prefix}{topic}" for topic in needed if topic not in there]
    if missing:
        print(f"warning: neither in the bag nor estimated: {', '.join(missing)}", file=sys.stderr)


def _refuse_strange_car(reader: BagReader, prefix: str, vehicle: Vehicle) -> None:
    """Refuse a car without any wheel in the bag, by the first wheel_states and the names of tyre_signals.

    Raises:
        BagError: the text names the wheels of both.
    """
    topics = [topic.name.removeprefix(prefix) for topic in reader.counts]
    tyres = sorted(name.removesuffix(_TYRE_SIGNALS) for name in topics if name.endswith(_TYRE_SIGNALS))
    joints = _first_joints(reader, prefix)
    if joints is None and not tyres:
        raise BagError(f"{reader.bag} holds no {prefix}{_WHEEL_STATES}: is it in another --namespace?")
    for topic, found, known in (
        (_WHEEL_STATES, joints, vehicle.joints),
        (f"*{_TYRE_SIGNALS}", tyres, vehicle.wheel_names),
    ):
        if found and not set(found) & set(known):
            raise BagError(
                f"{reader.bag}: {prefix}{topic} holds {', '.join(found)}, and no wheel of the car '{vehicle.name}': "
                f"{', '.join(known)}; is it another --vehicle?"
            )


def _first_joints(reader: BagReader, prefix: str) -> list[str] | None:
    """Return the names in the first wheel_states message that can be read; None where there is none."""
    states = [topic for topic in reader.counts if topic.name == prefix + _WHEEL_STATES]
    for topic, _, data in reader.messages(states):
        if topic.type != type_name(JointState):
            continue
        with suppress(ValueError):  # what cannot be decoded is counted when the bag is processed
            return list(decode(data, JointState).name)
    return None
