"""Longest update time: a clean drive, and tyre blocks of the largest size."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from friction_msgs.msg import TyreSignals
from numpy.typing import NDArray

from benchmarks.rows import Row, at_most
from campaigns.fuzz.clean_run import START, inputs_of
from friction_bags.offline.estimators import SMART_TYRE
from friction_runtime.stamps import header_at
from vehicle_models.encoder import EncoderParameters
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.tyre_ring import TyreRing
from vehicle_models.tyre_signal import AccelerometerParameters, TyreSignalSource

_RATE = 1e4
"""Samples of a tyre in a second."""
_LEAD_IN = 30_000
"""Samples of a drive before it, in which the angle of the wheel becomes known."""
_LONG = 100_000
"""Samples of a block that is far too long: 10 s."""
_WHEEL = "front_left"
_LARGEST_UPDATE = 0.1
"""Largest CPU time of an update in ordinary driving [s]: what subscribers' queues hold is five times that."""
_LARGEST_LONG_UPDATE = 1.0
"""Largest CPU time of a block of _LONG samples [s], a tenth of the time that it spans."""
_REPEATS = 2
"""The least of so many runs counts: other processes of the machine are no part of an update."""
Signal = NDArray[np.float32]
_PARTS = (*(slice(begin, begin + 50) for begin in range(0, _LEAD_IN, 50)), slice(_LEAD_IN, _LEAD_IN + _LONG))
"""Blocks as a sensor sends them, then the long one."""


def update_time_rows(makers: Mapping[str, Callable[[], Any]], drive: Sequence[tuple[str, Any]]) -> list[Row]:
    """Return a row for each processor with its slowest update, and one for each long block of a tyre.

    Args:
        makers: make a processor each, by name.
        drive: the clean drive, whose braking fills the windows of all methods.
    """
    rows: list[Row] = []
    for name, make in makers.items():
        inputs = inputs_of(make(), drive)
        slowest = min(_slowest(make(), inputs) for _ in range(_REPEATS))
        rows.append(_row(name, len(inputs), "clean drive", at_most(slowest, _LARGEST_UPDATE)))
    if SMART_TYRE in makers:
        for what, voltage, acceleration in _long_blocks():
            blocks = [_block(part, voltage[part], acceleration[part]) for part in _PARTS]
            slowest = min(_slowest(makers[SMART_TYRE](), blocks) for _ in range(_REPEATS))
            rows.append(_row(SMART_TYRE, len(blocks), what, at_most(slowest, _LARGEST_LONG_UPDATE)))
    return rows


def _row(name: str, messages: int, what: str, result: Row) -> Row:
    quantity = f"slowest update, {what} [s]"
    return {"processor": name, "messages": messages, "quantity": quantity, **result, "first": ""}


def _slowest(processor: Any, inputs: Sequence[tuple[str, Any]]) -> float:
    slowest = 0.0
    for topic, message in inputs:
        begun = time.thread_time()
        processor.process(topic, message)
        slowest = max(slowest, time.thread_time() - begun)
    return slowest


def _long_blocks() -> Iterator[tuple[str, Signal, Signal]]:
    """Yield names, voltages and accelerations: a drive, and what makes most crossings of the encoder."""
    ring = TyreRing()
    # The first wheel of the plant, whose teeth the calibration knows.
    source = TyreSignalSource(ring, AccelerometerParameters(), EncoderParameters(), wheel_seed=0, noise_seed=1)
    drive = source.advance(np.full(_LEAD_IN + _LONG, 20.0 / ring.radius), 0.0, ring.static_load)
    voltage, acceleration = drive.encoder_voltage, drive.radial_acceleration
    yield f"{_LONG} samples of a drive", voltage, acceleration
    swapping = np.where(np.arange(_LONG) % 2 == 0, 1.0, -1.0).astype(np.float32)
    yield f"{_LONG} samples that cross zero each time", np.append(voltage[:_LEAD_IN], swapping), acceleration
    noise = np.random.default_rng(0).normal(0.0, 1.0, (2, _LONG)).astype(np.float32)
    noisy = [np.append(each[:_LEAD_IN], noise[k]) for k, each in enumerate((voltage, acceleration))]
    yield f"{_LONG} samples of noise", noisy[0], noisy[1]


def _block(part: slice, voltage: Signal, acceleration: Signal) -> tuple[str, TyreSignals]:
    message = TyreSignals(
        header=header_at(START + round(part.start / _RATE * NANOSECONDS), _WHEEL),
        wheel=_WHEEL,
        sample_rate=_RATE,
        first_sample=part.start,
        encoder_voltage=array("f", voltage.tobytes()),
        radial_acceleration=array("f", acceleration.tobytes()),
        inflation_pressure=2e5,
    )
    return f"{_WHEEL}/tyre_signals", message
