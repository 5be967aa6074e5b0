"""Messages that no sensor sends: any value that a field can hold, in any field."""

from __future__ import annotations

from array import array
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.random import Generator

_FLOATS = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 1e-300, 1e18, -1e9, 3.6, -1.0, 9.81, 1e5)
_FLOATS32 = (np.nan, np.inf, -np.inf, 0.0, 3e38, -3e38, 1e-38, 1e9, -1.0, 5.0)
_BITS = {"8": 8, "16": 16, "32": 32, "64": 64}
_LONG = 100_000
"""Length of an array that is far too long."""
_RARELY = 1e-3
"""Share of the messages with arrays of this length: one takes as much time as a thousand others."""
_TEXTS = ("", "x", "front_left", "rear_right", "vehicle", "\u20ac" * 100, "wheel\n\x00")


def garbage(message: Any, rng: Generator) -> Any:
    """Return a copy of a message with one to three fields, at any depth, that hold something else.

    Rarely, all its arrays are far too long.
    """
    broken = deepcopy(message)
    if rng.random() < _RARELY:
        for name, kind in broken.get_fields_and_field_types().items():
            value = getattr(broken, name)
            if kind.startswith("sequence<") and len(value):
                setattr(broken, name, _joined(*[value] * (_LONG // len(value))))
        return broken
    for _ in range(int(rng.integers(1, 4))):
        _break(broken, rng)
    return broken


def _break(message: Any, rng: Generator) -> None:
    kinds = message.get_fields_and_field_types()
    name = str(rng.choice(list(kinds)))
    value = getattr(message, name)
    if hasattr(value, "get_fields_and_field_types"):
        _break(value, rng)
    elif isinstance(value, (array, np.ndarray, list)):
        setattr(message, name, _other_sequence(value, kinds[name], rng))
    else:
        setattr(message, name, _other(value, kinds[name], rng))


def _other(value: Any, kind: str, rng: Generator) -> Any:
    """Another value of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return str(rng.choice(_TEXTS))
    if isinstance(value, float):
        return float(rng.choice(_FLOATS)) if rng.random() < 0.8 else float(value * 10.0 ** rng.uniform(-6, 6))
    if isinstance(value, int):
        return _integer(value, kind, rng)
    return value


def _integer(value: int, kind: str, rng: Generator) -> int:
    bits = next((_BITS[size] for size in _BITS if kind.endswith(size)), 8)
    low, high = (0, 2**bits - 1) if kind.startswith("u") or bits == 8 else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if kind == "int8":
        low, high = -128, 127
    choices = (
        low,
        high,
        0,
        1,
        value + 1,
        value - 1,
        value + 1000,
        value + 2**53,
        value + 2**60,
        int(rng.integers(0, 2**31)),
    )
    return min(max(choices[int(rng.integers(len(choices)))], low), high)


def _other_sequence(value: Any, kind: str, rng: Generator) -> Any:
    """Another length, or other elements."""
    if len(value) == 0:
        return value
    fixed = not kind.startswith("sequence<")
    choice = 1.0 if fixed else rng.random()
    if choice < 0.1:
        return value[:0]
    if choice < 0.3:
        return value[: int(rng.integers(len(value)))]
    if choice < 0.5:
        return _joined(value, value)
    return _with_other_element(value, kind, rng)


def _joined(*parts: Any) -> Any:
    joined = parts[0][:]
    for part in parts[1:]:
        joined.extend(part)
    return joined


def _with_other_element(value: Any, kind: str, rng: Generator) -> Any:
    changed = value.copy() if isinstance(value, np.ndarray) else value[:]
    number = int(rng.integers(len(changed)))
    element = changed[number]
    if hasattr(element, "get_fields_and_field_types"):
        _break(element, rng)
    elif "float" in kind:
        changed[number] = float(rng.choice(_FLOATS32))
    elif "double" in kind:
        changed[number] = float(rng.choice(_FLOATS))
    else:
        changed[number] = _other(element, kind.removeprefix("sequence<").removesuffix(">"), rng)
    return changed
