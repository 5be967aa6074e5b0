"""What is to be done with a bag, as each of the processes that do it must know it."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sensor_msgs.msg import JointState

from friction_bags.bag_format import BagError
from friction_bags.bag_reader import BagReader
from friction_bags.cdr import decode
from friction_bags.estimators import SMART_TYRE, WHEEL_ESTIMATORS, build_processors
from friction_bags.message_definition import type_name
from friction_runtime.processor import Processor, Report

_WHEEL_STATES = "wheel_states"
_TYRE_SIGNALS = "/tyre_signals"
_MOST_REPORTS = 100


@dataclass(frozen=True)
class ProcessOptions:
    """What a user asks for."""

    estimators: tuple[str, ...] = ()
    """Names of estimators; empty for all whose inputs the bag has."""
    wheels: tuple[str, ...] = ()
    """Names of the wheels; empty for those of the bag."""
    parameter_files: tuple[Path, ...] = ()
    """ROS parameter files over those that the packages ship."""
    namespace: str = "/"
    """Of the topics, e.g. /car; / for none."""
    outputs_only: bool = False
    """Whether to leave out the topics of the bag."""

    @property
    def prefix(self) -> str:
        """What the names of the topics begin with."""
        return self.namespace.rstrip("/") + "/"


@dataclass(frozen=True)
class OfflinePlan:
    """What becomes of the topics of one bag."""

    bag: Path
    estimators: tuple[str, ...]
    wheels: tuple[str, ...]
    parameter_files: tuple[Path, ...]
    taken: tuple[str, ...]
    """Of each topic in the bag: its relative name if the estimators take it, else nothing."""
    copied: tuple[bool, ...]
    """Of each topic in the bag: whether it is copied to the other."""

    def processors(self, report: Report) -> list[Processor]:
        """Make the processors.

        Raises:
            ParameterError: a parameter is bad.
        """
        return build_processors(self.estimators, self.wheels, self.parameter_files, report)


class SayOnce:
    """Report of processors: each text once, without mere information."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(self, severity: str, text: str) -> None:
        """Print what was not printed before."""
        if severity != "info" and text not in self._said and len(self._said) < _MOST_REPORTS:
            self._said.add(text)
            print(f"{severity}: {text}", file=sys.stderr)


def plan_for(reader: BagReader, options: ProcessOptions, report: Report) -> tuple[OfflinePlan, list[Processor]]:
    """Find out what a bag asks for; return also the processors of the plan.

    Raises:
        BagError: it names no wheels.
        ParameterError: a parameter is bad.
    """
    prefix = options.prefix
    names = [topic.name.removeprefix(prefix) for topic in reader.counts]
    estimators = options.estimators
    if not estimators:
        has_tyres = any(name.endswith(_TYRE_SIGNALS) for name in names)
        estimators = (*(WHEEL_ESTIMATORS if _WHEEL_STATES in names else ()), *((SMART_TYRE,) if has_tyres else ()))
    wheels = options.wheels or _wheels_of(reader, prefix)
    processors = build_processors(estimators, wheels, options.parameter_files, report)
    made = {topic for processor in processors for topic in processor.outputs}
    taken = _taken(reader, processors, made, prefix)
    copied = tuple(not options.outputs_only and name not in made for name in names)
    return OfflinePlan(reader.bag, estimators, wheels, options.parameter_files, tuple(taken), copied), processors


def output_numbers(processors: Sequence[Processor]) -> dict[str, int]:
    """Numbers of the topics that processors make, in the order in which outputs of one message are written."""
    topics = dict.fromkeys(topic for processor in processors for topic in processor.outputs)
    return {topic: number for number, topic in enumerate(topics)}


def _taken(reader: BagReader, processors: Sequence[Processor], made: set[str], prefix: str) -> list[str]:
    """Relative names of the topics of the bag that processors take and none of them makes, nothing of the others."""
    kinds: dict[str, Any] = {}
    for processor in processors:
        kinds.update(processor.sensors)
        kinds.update(processor.estimates)
    taken = []
    for topic in reader.counts:
        name = topic.name.removeprefix(prefix)
        fits = name in kinds and name not in made
        if fits and type_name(kinds[name]) != topic.type:
            print(f"warning: {topic.name} is {topic.type}, not {type_name(kinds[name])}: not taken", file=sys.stderr)
            fits = False
        taken.append(name if fits else "")
    return taken


def _wheels_of(reader: BagReader, prefix: str) -> tuple[str, ...]:
    """Wheels that the first wheel_states message names, or those with tyre_signals."""
    states = [topic for topic in reader.counts if topic.name == prefix + _WHEEL_STATES]
    for topic, _, data in reader.messages(states):
        if topic.type == type_name(JointState):
            return tuple(decode(data, JointState).name)
    names = [topic.name.removeprefix(prefix) for topic in reader.counts if topic.name.endswith(_TYRE_SIGNALS)]
    if not names:
        raise BagError(f"{reader.bag} holds no {prefix}{_WHEEL_STATES}: is it in another --namespace?")
    return tuple(name.removesuffix(_TYRE_SIGNALS) for name in sorted(names))
