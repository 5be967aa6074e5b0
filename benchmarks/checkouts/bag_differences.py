"""Differences between the messages of two bags, each decoded by its own definitions."""

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection

from benchmarks.checkouts.message_differences import difference, flat
from benchmarks.rows import Row, at_most

_Key = tuple[int, int]
"""Header stamp of a message [ns] (recording stamp where it has no header), and its number among those of this stamp."""
_Messages = dict[_Key, tuple[bytes, Any]]
"""Data and decoded message."""


@dataclass
class TopicDifference:
    """Differences on topics of one kind, such as slip: the last part of their names."""

    before: int = 0
    """Messages."""
    after: int = 0
    same_bits: int = 0
    """Messages whose common fields are the same to the last bit."""
    unpaired: int = 0
    """Messages of stamps that the other bag lacks."""
    largest: float = 0.0
    """Largest difference of a float."""
    largest_in: str = ""
    """Its field."""
    fields: Counter[str] = field(default_factory=Counter)
    """Messages in which a field differs, by field; texts are apart."""
    texts: Counter[str] = field(default_factory=Counter)
    in_one: set[str] = field(default_factory=set)
    """Fields that one of the definitions lacks."""
    missing: list[str] = field(default_factory=list)
    """Topics that one of the bags lacks."""

    def row(self) -> Row:
        """Flat row: it fails where something differs that is not only a text."""
        return {
            "messages_before": self.before,
            "messages_after": self.after,
            "equal_to_the_last_bit": self.same_bits,
            "unpaired": self.unpaired,
            "largest_difference": self.largest,
            "largest_in": self.largest_in,
            "fields_that_differ": _counted(self.fields),
            "texts_that_differ": _counted(self.texts),
            "fields_in_one_only": ", ".join(sorted(self.in_one)),
            "missing_topics": ", ".join(self.missing),
            "quantity": "differences",
            **at_most(self.unpaired + self.fields.total() + len(self.missing), 0),
        }


def _counted(names: Counter[str]) -> str:
    return ", ".join(f"{name} ({count})" for name, count in names.most_common())


def bag_differences(before: Path, after: Path) -> dict[str, TopicDifference]:
    """Compare all messages of two bags: paired by topic, stamp and order; the differences by kind of topic.

    Topics without messages are those of a bag that lacks them.

    Raises:
        rosbags.highlevel.AnyReaderError: a bag cannot be read.
    """
    found: dict[str, TopicDifference] = defaultdict(TopicDifference)
    with AnyReader([before]) as old, AnyReader([after]) as new:
        topics = _topics(old), _topics(new)
        for name in sorted(topics[0].keys() | topics[1].keys()):
            kind = found[name.rpartition("/")[2]]
            sides = [_messages(bag, of.get(name, [])) for bag, of in zip((old, new), topics, strict=True)]
            kind.before += len(sides[0])
            kind.after += len(sides[1])
            if not all(sides):
                kind.missing.append(f"{name} (only {'before' if sides[0] else 'after'})")
                continue
            kind.unpaired += len(sides[0].keys() ^ sides[1].keys())
            if len({(each.msgtype, each.msgdef.data) for of in topics for each in of[name]}) > 1:
                _compare(kind, *sides)
            else:
                _compare_unless_alike(kind, *sides)
    return dict(found)


def _topics(bag: AnyReader) -> dict[str, list[Connection]]:
    return {name: topic.connections for name, topic in bag.topics.items() if topic.msgcount}


def _messages(bag: AnyReader, connections: list[Connection]) -> _Messages:
    found: _Messages = {}
    of_stamp: Counter[int] = Counter()
    for connection, recorded, data in bag.messages(connections) if connections else ():
        message: Any = bag.deserialize(data, connection.msgtype)
        stamp = recorded
        if hasattr(message, "header"):
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        found[stamp, of_stamp[stamp]] = bytes(data), message
        of_stamp[stamp] += 1
    return found


def _compare_unless_alike(kind: TopicDifference, before: _Messages, after: _Messages) -> None:
    """Compare messages of one definition: those of the same bytes are the same."""
    alike = {key for key in before.keys() & after.keys() if before[key][0] == after[key][0]}
    kind.same_bits += len(alike)
    _compare(kind, *({key: each for key, each in side.items() if key not in alike} for side in (before, after)))


def _compare(kind: TopicDifference, before: _Messages, after: _Messages) -> None:
    for key in before.keys() & after.keys():
        found = difference(flat(before[key][1]), flat(after[key][1]))
        kind.same_bits += found.same_bits
        kind.fields.update(found.beyond)
        kind.texts.update(found.texts)
        kind.in_one.update(f"{name} (only before)" for name in found.only_before)
        kind.in_one.update(f"{name} (only after)" for name in found.only_after)
        for name, size in found.floats.items():
            if size > kind.largest:
                kind.largest, kind.largest_in = size, name
