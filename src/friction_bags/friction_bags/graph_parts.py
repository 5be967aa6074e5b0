"""Division of the processors of a graph into parts that run without each other."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from friction_runtime.processor import Processor


@dataclass(frozen=True)
class GraphPart:
    """Processors that can run without the others."""

    processors: tuple[Processor, ...]
    outputs: frozenset[str]
    """Topics of which it is the one to give the messages."""


def independent_parts(processors: Sequence[Processor], most: int) -> list[GraphPart]:
    """Divide processors into at most so many parts that need nothing of each other.

    A processor for several wheels (wheel_slip) runs in every part. The others stay with those whose topics they take.
    The first of several parts has less than its share: its process also copies topics and writes all outputs.
    """
    shared = [processor for processor in processors if len(_wheels(processor)) > 1]
    groups = _connected([processor for processor in processors if processor not in shared])
    if most == 1 or len(groups) < 2 or _made(groups) & _needed(shared):
        return [GraphPart(tuple(processors), frozenset(_made([processors])))]
    first = max(1, len(groups) // most - 1)
    rest = groups[first:]
    shares = [groups[:first], *(rest[begin :: most - 1] for begin in range(min(most - 1, len(rest))))]
    given = [_made([*share, *([shared] if share is shares[0] else [])]) for share in shares]
    return [
        GraphPart((*shared, *(processor for group in share for processor in group)), frozenset(topics))
        for share, topics in zip(shares, given, strict=True)
    ]


def _connected(processors: Sequence[Processor]) -> list[list[Processor]]:
    """Groups of processors that take each other's topics, in the order of their first."""
    groups: list[list[Processor]] = []
    for processor in processors:
        made, needed = set(processor.outputs), _needed([processor])
        joined = [group for group in groups if _made([group]) & needed or made & _needed(group)]
        groups = [group for group in groups if group not in joined]
        groups.append([*(member for group in joined for member in group), processor])
    return groups


def _made(groups: Iterable[Sequence[Processor]]) -> set[str]:
    return {topic for group in groups for processor in group for topic in processor.outputs}


def _needed(processors: Iterable[Processor]) -> set[str]:
    return {topic for each in processors for topics in (each.sensors, each.estimates) for topic in topics}


def _wheels(processor: Processor) -> set[str]:
    return {topic.split("/", 1)[0] for topic in processor.outputs}
