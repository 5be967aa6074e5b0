"""Division of the processors of a graph into stages, each of which needs topics of earlier stages only."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

from friction_runtime.processor import Processor

Stage = tuple[Processor, ...]


def graph_stages(processors: Sequence[Processor], most: int) -> list[Stage]:
    """Divide processors into at most `most` stages that take about the same time.

    Processors for several wheels (wheel_slip) are in the first stage, which also reads the bag and so has fewer of the
    others. The others stay with those whose topics they take.
    """
    shared = [processor for processor in processors if len(_wheels(processor)) > 1]
    groups = _connected([processor for processor in processors if processor not in shared])
    count = min(most, len(groups))
    alone = [processor for group in groups for processor in group]
    if count < 2 or _made(alone) & _needed(shared):
        return [tuple(processors)]
    inner = [max(stage, (len(groups) + 1) * stage // count - 1) for stage in range(1, count)]
    shares = [groups[begin:end] for begin, end in pairwise([0, *inner, len(groups)])]
    stages = [tuple(processor for group in share for processor in group) for share in shares]
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


def _made(processors: Iterable[Processor]) -> set[str]:
    return {topic for processor in processors for topic in processor.outputs}


def _needed(processors: Iterable[Processor]) -> set[str]:
    return {topic for each in processors for topics in (each.sensors, each.estimates) for topic in topics}


def _wheels(processor: Processor) -> set[str]:
    return {topic.rpartition("/")[0] for topic in processor.outputs}
