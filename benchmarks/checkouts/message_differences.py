"""Differences between two decoded messages, field by field; their definitions may differ."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

TOLERANCE = 1e-9
"""Largest difference of floats that counts as none: relative above 1, absolute below."""

Fields = Mapping[str, Any]
"""Numbers, arrays of numbers and texts of a message by dotted name."""


@dataclass(frozen=True)
class MessageDifference:
    """What two messages do not have in common."""

    same_bits: bool
    """Are all values of common fields the same to the last bit? NaN is the same as NaN."""
    floats: Mapping[str, float]
    """Difference of each float field that is not the same: relative above 1, absolute below; inf beside NaN."""
    others: tuple[str, ...]
    """Integers, booleans and lengths that are not the same."""
    texts: tuple[str, ...]
    """Texts that are not the same."""
    only_before: tuple[str, ...]
    only_after: tuple[str, ...]
    """Fields that one of the definitions lacks."""

    @property
    def beyond(self) -> tuple[str, ...]:
        """Fields that differ by more than the tolerance, or at all where they are no floats; without texts."""
        return (*(name for name, size in self.floats.items() if not size <= TOLERANCE), *self.others)


def flat(message: Any, prefix: str = "") -> dict[str, Any]:
    """Fields of a message that rosbags has decoded, by dotted name; elements of a sequence of messages by number."""
    found: dict[str, Any] = {}
    for each in fields(message):
        found.update(_leaves(f"{prefix}{each.name}", getattr(message, each.name)))
    return found


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if is_dataclass(value):
        yield from flat(value, f"{name}.").items()
    elif isinstance(value, list):
        yield f"{name}.length", len(value)
        for number, each in enumerate(value):
            yield from _leaves(f"{name}.{number}", each)
    else:
        yield name, value


def difference(before: Fields, after: Fields) -> MessageDifference:
    """Compare two messages made by `flat`."""
    floats: dict[str, float] = {}
    others, texts = [], []
    for name in before.keys() & after.keys():
        old, new = before[name], after[name]
        if isinstance(old, str) and isinstance(new, str):
            if old != new:
                texts.append(name)
        elif not _is_float(old) or not _is_float(new) or np.shape(old) != np.shape(new):
            if not np.array_equal(old, new):
                others.append(name)
        elif not _same_bits(old, new):
            floats[name] = _size(old, new)
    return MessageDifference(
        same_bits=not (floats or others or texts),
        floats=floats,
        others=tuple(others),
        texts=tuple(texts),
        only_before=tuple(before.keys() - after.keys()),
        only_after=tuple(after.keys() - before.keys()),
    )


def _is_float(value: Any) -> bool:
    return np.asarray(value).dtype.kind == "f"


def _same_bits(old: Any, new: Any) -> bool:
    a, b = np.asarray(old), np.asarray(new)
    return bool(np.all((a == b) & (np.signbit(a) == np.signbit(b)) | np.isnan(a) & np.isnan(b)))


def _size(old: Any, new: Any) -> float:
    a, b = np.asarray(old, dtype=np.float64), np.asarray(new, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        sizes = np.abs(a - b) / np.maximum(1.0, np.maximum(np.abs(a), np.abs(b)))
    # What is left NaN here is a NaN or an infinity beside something else.
    return float(np.max(np.where((a == b) | np.isnan(a) & np.isnan(b), 0.0, np.nan_to_num(sizes, nan=np.inf))))
