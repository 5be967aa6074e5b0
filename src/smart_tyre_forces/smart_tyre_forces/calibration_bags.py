"""Runs for the calibration from bags: tyre blocks of each wheel and the car's acceleration."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.highlevel.anyreader import AnyReaderError

from smart_tyre_forces.calibrate import WheelRun
from smart_tyre_forces.front_template import FrontRefiner
from smart_tyre_forces.patch_tracker import Passage, PatchTracker, TrackerParameters
from smart_tyre_forces.tooth_table import ToothTable

Array = NDArray[np.float64]

_SMOOTHING = 0.05
"""The acceleration is averaged over this time [s]: engine and road shake the car as well."""


@dataclass(frozen=True)
class Block:
    """One tyre_signals message."""

    stamp: float
    """Of the first sample [s]."""
    first_sample: int
    voltage: NDArray[np.float32]
    acceleration: NDArray[np.float32]


@dataclass(frozen=True)
class BagRun:
    """What a bag holds for the calibration."""

    bag: Path
    tyres: dict[str, list[Block]]
    """By wheel."""
    time: Array
    """Stamps of the acceleration [s]."""
    acceleration: Array
    """Of the car, forward positive, averaged [m/s^2]."""

    def table(self, wheel: str, parameters: TrackerParameters) -> ToothTable:
        """Tooth table of a wheel, learned from this bag.

        Raises:
            ValueError: the wheel never turned evenly for long enough.
        """
        tracker = PatchTracker(parameters)
        self._passages(wheel, tracker)
        if tracker.wheel.table is None:
            raise ValueError(f"{self.bag}: {wheel} never turned evenly for 32 revolutions: no tooth table")
        return tracker.wheel.table

    def run(
        self,
        wheel: str,
        rear: bool,
        table: ToothTable,
        parameters: TrackerParameters,
        refiner: FrontRefiner | None = None,
    ) -> WheelRun:
        """Passages of a wheel, with the acceleration on their time scale."""
        tracker = PatchTracker(parameters, table, refiner)
        begin = self.tyres[wheel][0]
        origin = begin.stamp - begin.first_sample / parameters.sample_rate
        return WheelRun(wheel, rear, self._passages(wheel, tracker), self.time - origin, self.acceleration)

    def _passages(self, wheel: str, tracker: PatchTracker) -> list[Passage]:
        return [p for b in self.tyres[wheel] for p in tracker.push(b.first_sample, b.voltage, b.acceleration)]


def read(bag: Path, imu_topic: str = "imu/data") -> BagRun:
    """Read a bag; topics may have any namespace.

    Raises:
        ValueError: the bag cannot be read, or lacks tyre signals or the acceleration; the message names the bag.
    """
    tyres: dict[str, list[Block]] = {}
    stamps: list[float] = []
    accelerations: list[float] = []
    try:
        with AnyReader([bag]) as reader:
            wanted = [c for c in reader.connections if c.topic.endswith(("/tyre_signals", imu_topic))]
            for connection, _, data in reader.messages(connections=wanted):
                message: Any = reader.deserialize(data, connection.msgtype)
                stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
                if connection.topic.endswith("/tyre_signals"):
                    signals = (message.encoder_voltage, message.radial_acceleration)
                    tyres.setdefault(message.wheel, []).append(Block(stamp, int(message.first_sample), *signals))
                else:
                    stamps.append(stamp)
                    accelerations.append(float(message.linear_acceleration.x))
    except (AnyReaderError, OSError) as problem:
        raise ValueError(f"{bag}: {problem}") from problem
    if not tyres or len(stamps) < 2:
        raise ValueError(f"{bag}: needs <wheel>/tyre_signals and {imu_topic}")
    time = np.asarray(stamps)
    width = max(1, round(_SMOOTHING / float(np.median(np.diff(time)))))
    padded = np.pad(np.asarray(accelerations), (width // 2, (width - 1) // 2), mode="edge")
    return BagRun(bag, tyres, time, np.convolve(padded, np.full(width, 1.0 / width), mode="valid"))
