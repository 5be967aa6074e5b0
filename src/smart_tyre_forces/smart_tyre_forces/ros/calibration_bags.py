"""Runs for the calibration from bags: tyre blocks of each wheel and the car's acceleration."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.highlevel.anyreader import AnyReaderError

from smart_tyre_forces.front_template import FrontRefiner
from smart_tyre_forces.patch_tracker import Passage, PatchTracker, TrackerParameters
from smart_tyre_forces.tooth_table import ToothTable
from smart_tyre_forces.wheel_run import WheelRun
from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.vehicle import Vehicle, Wheel

Array = NDArray[np.float64]

_SMOOTHING = 0.05
"""Time over which the acceleration is averaged [s]: engine and road shake the car as well."""


@dataclass(frozen=True)
class Block:
    """One tyre_signals message."""

    stamp: float
    """Stamp of the first sample [s]."""
    first_sample: int
    voltage: NDArray[np.float32]
    acceleration: NDArray[np.float32]


@dataclass(frozen=True)
class BagRun:
    """Content of a bag for the calibration."""

    bag: Path
    tyres: dict[str, list[Block]]
    """Blocks of each wheel."""
    time: Array
    """Stamps of the acceleration [s]."""
    acceleration: Array
    """Acceleration of the car, forward positive, averaged [m/s^2]."""

    def table(self, wheel: Wheel, parameters: TrackerParameters) -> ToothTable:
        """Learn the tooth table of a wheel from this bag.

        Raises:
            ValueError: the wheel never turned evenly for long enough.
        """
        tracker = PatchTracker(wheel, parameters)
        self._passages(wheel, tracker)
        if tracker.wheel.table is None:
            raise ValueError(f"{self.bag}: {wheel.name} never turned evenly for 32 revolutions: no tooth table")
        return tracker.wheel.table

    def run(
        self,
        wheel: Wheel,
        table: ToothTable,
        parameters: TrackerParameters,
        refiner: FrontRefiner | None = None,
    ) -> WheelRun:
        """Return the passages of a wheel, with the acceleration on their time scale."""
        tracker = PatchTracker(wheel, parameters, table, refiner)
        begin = self.tyres[wheel.name][0]
        origin = begin.stamp - begin.first_sample / parameters.sample_rate
        return WheelRun(wheel, self._passages(wheel, tracker), self.time - origin, self.acceleration)

    def _passages(self, wheel: Wheel, tracker: PatchTracker) -> list[Passage]:
        return [p for b in self.tyres[wheel.name] for p in tracker.push(b.first_sample, b.voltage, b.acceleration)]


def noted_vehicle(bag: Path) -> str:
    """Return the vehicle file in the note of a bag, empty where there is none."""
    try:
        document: Any = yaml.safe_load(Path(bag, "metadata.yaml").read_text(encoding="utf-8"))
        notes = document["rosbag2_bagfile_information"].get("custom_data") or {}
        return str(notes.get("vehicle", ""))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        return ""


def read(bag: Path, vehicle: Vehicle, imu_topic: str = "imu/data") -> BagRun:
    """Read a bag of a car; topics may have any namespace.

    Raises:
        ValueError: the bag cannot be read, lacks tyre signals or the acceleration, or holds a wheel that the car does
            not have; the message names the bag.
    """
    tyres: dict[str, list[Block]] = {}
    stamps: list[float] = []
    accelerations: list[float] = []
    try:
        with AnyReader([bag]) as reader:
            wanted = [c for c in reader.connections if c.topic.endswith(("/tyre_signals", imu_topic))]
            for connection, _, data in reader.messages(connections=wanted):
                message: Any = reader.deserialize(data, connection.msgtype)
                stamp = message.header.stamp.sec + NANOSECOND * message.header.stamp.nanosec
                if connection.topic.endswith("/tyre_signals"):
                    signals = (message.encoder_voltage, message.radial_acceleration)
                    tyres.setdefault(message.wheel, []).append(Block(stamp, int(message.first_sample), *signals))
                else:
                    stamps.append(stamp)
                    accelerations.append(vehicle.accelerometer.forward(message.linear_acceleration))
    except (AnyReaderError, OSError) as problem:
        raise ValueError(f"{bag}: {problem}") from problem
    if not tyres or len(stamps) < 2:
        raise ValueError(f"{bag}: needs <wheel>/tyre_signals and {imu_topic}")
    if strangers := sorted(set(tyres) - set(vehicle.wheel_names)):
        raise ValueError(
            f"{bag}: '{strangers[0]}' is not a wheel of the car, which has {', '.join(vehicle.wheel_names)}"
        )
    time = np.asarray(stamps)
    width = max(1, round(_SMOOTHING / float(np.median(np.diff(time)))))
    padded = np.pad(np.asarray(accelerations), (width // 2, (width - 1) // 2), mode="edge")
    return BagRun(bag, tyres, time, np.convolve(padded, np.full(width, 1.0 / width), mode="valid"))
