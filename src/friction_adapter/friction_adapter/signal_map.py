"""A signal map: where each signal of a car comes from, in which unit, and the message that carries it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import nan
from pathlib import Path
from typing import Final

from vehicle_models.vehicle import Vehicle

WHEEL_STATES: Final = "wheel_states"
IMU: Final = "imu/data"
VEHICLE_VELOCITY: Final = "vehicle_velocity"
BRAKE_PRESSURE: Final = "brake_pressure"
BRAKE_DEMAND: Final = "brake_demand"
BRAKE_TORQUE_REQUEST: Final = "can/total_brake_torque_request"
ARRIVAL: Final = "arrival"
"""In place of a field: the time at which a message arrived, or was recorded."""


@dataclass(frozen=True)
class Quantity:
    """One quantity."""

    name: str
    dimension: str
    """Key of the table of units."""
    message: str
    """Topic of the message that carries it, below the wheel for `brake_pressure`."""
    per_wheel: bool
    needs: str
    """Quantity that the message has no meaning without; empty for none but itself."""
    has_stddev: bool
    """Whether the message carries its standard deviation."""
    description: str


QUANTITIES: Final = {
    each.name: each
    for each in (
        Quantity("wheel_speed", "wheel_speed", WHEEL_STATES, True, "", False, "speed of each wheel"),
        Quantity("acceleration", "acceleration", IMU, False, "", True, "reading of the accelerometer along the car"),
        Quantity("lateral_acceleration", "acceleration", IMU, False, "acceleration", False, "leftward positive"),
        Quantity("yaw_rate", "yaw_rate", IMU, False, "acceleration", False, "counter-clockwise positive"),
        Quantity("speed", "speed", VEHICLE_VELOCITY, False, "", True, "speed of the car, forward positive"),
        Quantity("lateral_speed", "speed", VEHICLE_VELOCITY, False, "speed", False, "leftward positive"),
        Quantity("brake_pressure", "pressure", BRAKE_PRESSURE, True, "", True, "pressure at the brake of each wheel"),
        Quantity("brake_demand", "pressure", BRAKE_DEMAND, False, "", False, "line pressure that the driver demands"),
        Quantity(
            "brake_torque_request",
            "torque",
            BRAKE_TORQUE_REQUEST,
            False,
            "",
            False,
            "brake torque of all wheels together; kept in the bag, no estimator takes it",
        ),
    )
}
"""By name, in the order in which the messages of one instant are sent."""


class Kind(Enum):
    """Where a signal is found."""

    TOPIC = "topic"
    CAN = "can"
    TABLE = "table"


@dataclass(frozen=True)
class Origin:
    """Source of a signal."""

    kind: Kind
    topic: str = ""
    """Name of the topic; empty for CAN and tables."""
    type: str = ""
    """Message type of the topic, e.g. sensor_msgs/msg/JointState."""


@dataclass(frozen=True)
class Flag:
    """A field with the validity of a signal."""

    field: str
    is_value: float | str
    """Value with which it is."""


@dataclass(frozen=True)
class Signal:
    """One quantity of the car or of one wheel."""

    quantity: Quantity
    wheel: str
    """Name of the wheel; empty for a quantity of the car."""
    origin: Origin
    fields: tuple[str, ...]
    """Fields, CAN signals or columns; several are added up."""
    line: int
    """Line in the file."""
    unit: str = ""
    """Name in UNITS; empty for that of the DBC file, else the SI unit."""
    mean: bool = False
    """Whether the sum of several fields is divided by their number."""
    scale: float = 1.0
    offset: float = 0.0
    sign: int = 1
    full_scale: float = 1.0
    """100 % [SI unit]."""
    radius: float = nan
    """By which the sender makes the speed of a rim [m]; NaN: that of the vehicle file."""
    latency: int = 0
    """Age of the value at its stamp [ns]."""
    stddev: float = nan
    """Standard deviation in `unit`; NaN: not stated."""
    invalid: tuple[float, ...] = ()
    """Raw values that mean that there is none."""
    flag: Flag | None = None
    counter: float = nan
    """Number at which a counter of edges wraps."""
    stamp: str = "header.stamp"
    """Field, column, or ARRIVAL."""
    stamp_unit: str = ""
    """Key of STAMP_UNITS; empty for that by the size of the number."""

    @property
    def title(self) -> str:
        """Quantity and wheel, for messages to the user."""
        return f"'{self.quantity.name}'{f' of {self.wheel}' if self.wheel else ''}"


@dataclass(frozen=True)
class CanBus:
    """How frames of a CAN bus are read."""

    dbc: Path | None = None
    topic: str = ""
    """Topic of can_msgs/Frame; empty where frames come from logs only."""
    bus: str = ""
    """Name or number of the bus in a log, as the log has it; empty for all."""
    by_arrival: bool = False
    """Whether frames of the topic are stamped by their arrival."""


@dataclass(frozen=True)
class SignalMap:
    """All signals of a car."""

    path: Path
    vehicle: Vehicle
    vehicle_reference: str
    """Name of a shipped vehicle file, or absolute path."""
    signals: tuple[Signal, ...]
    stamp_offset: int = 0
    """Added to every stamp [ns]."""
    together: int = 5_000_000
    """Messages whose stamps are at most this far apart are of one instant [ns]."""
    can: CanBus = field(default_factory=CanBus)
    notes: Mapping[str, str] = field(default_factory=dict)
    """Notes for a bag that is made with this map."""

    @property
    def topics(self) -> dict[str, str]:
        """Type of each topic that signals come from, without that of CAN frames."""
        return {each.origin.topic: each.origin.type for each in self.signals if each.origin.kind is Kind.TOPIC}

    def has(self, quantity: str) -> bool:
        """Whether the map names a quantity."""
        return any(each.quantity.name == quantity for each in self.signals)

    @property
    def cannot(self) -> tuple[str, ...]:
        """What cannot be estimated with these signals, and what to add: a sentence each."""
        texts = []
        if not self.has("wheel_speed"):
            texts.append("nothing can be estimated without 'wheel_speed': add the speed of each wheel")
        if not self.has("acceleration"):
            texts.append(
                "without 'acceleration', wheel_slip needs use_imu: false, and has no speed while the wheels slide: add "
                "the accelerometer along the car"
            )
        if not self.has("brake_pressure"):
            texts.append(
                "without 'brake_pressure' there is no brake torque: slips and one curve of the whole car (method "
                "'vehicle') are all there is; add the pressure at each wheel, or that of the line: `fields: {all: ...}`"
            )
        return tuple(texts)
