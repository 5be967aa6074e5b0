"""Serialized messages that are none: what a defective or hostile sender may put on a topic."""

from __future__ import annotations

from numpy.random import Generator

_ENCAPSULATION = 4
_LONGEST = 4096


def raw_garbage(serialized: bytes, rng: Generator) -> bytes:
    """Return something else in place of a serialized message: broken, cut, of another encapsulation, or noise."""
    kind = int(rng.integers(6))
    if kind == 0:
        return bytes(rng.bytes(int(rng.integers(_LONGEST))))
    if kind == 1:
        return serialized[: int(rng.integers(len(serialized)))]
    if kind == 2:
        return bytes(rng.bytes(_ENCAPSULATION)) + serialized[_ENCAPSULATION:]
    if kind == 3:
        return serialized + bytes(rng.bytes(int(rng.integers(_LONGEST))))
    if kind == 4:
        return _flipped(serialized, rng)
    return _with_long_length(serialized, rng)


def _flipped(serialized: bytes, rng: Generator) -> bytes:
    """Flip one to twenty bits."""
    broken = bytearray(serialized)
    for _ in range(int(rng.integers(1, 21))):
        broken[int(rng.integers(len(broken)))] ^= 1 << int(rng.integers(8))
    return bytes(broken)


def _with_long_length(serialized: bytes, rng: Generator) -> bytes:
    """Claim a length of up to 4 GiB somewhere, where the length of a text or of an array may stand."""
    broken = bytearray(serialized)
    words = max((len(broken) - _ENCAPSULATION) // 4, 1)
    begin = _ENCAPSULATION + 4 * int(rng.integers(words))
    broken[begin : begin + 4] = int(rng.integers(2**24, 2**32)).to_bytes(4, "little")
    return bytes(broken)
