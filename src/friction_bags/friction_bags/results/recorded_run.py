"""The values of a recorded run, topic by topic, as arrays over time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_bags.results.places import Places, places_of
from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

VEHICLE = "vehicle"
"""Stands for the name of a wheel in the topics of what speaks of the whole car."""
WHY = "why"
"""Column of what has a validity: 0 where it is valid, else the number of the reason, counted from 1."""

VALID = "validity.valid"
"""Field of what has a validity."""
Columns = Mapping[str, tuple[str, ...]]
"""Fields that are read, by the type of the message."""
COLUMNS: Columns = {
    "friction_msgs/msg/WheelSlip": ("slip", "slip_rate", "vehicle_speed", "wheel_speed", VALID),
    "friction_msgs/msg/FrictionSlope": (
        *("sign", "h", "indicator", VALID, "crossings", "crossing_sign", "slip_at_crossing", "delay"),
        *("crossing_stamp.sec", "crossing_stamp.nanosec"),
    ),
    "friction_msgs/msg/SlopeVote": ("indicator",),
    "friction_msgs/msg/FrictionCurve": (
        *("theta_1", "theta_2", "theta_3", "lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev"),
        *("slip", "mu", "probability_beyond_peak", VALID),
    ),
    "friction_msgs/msg/SupervisorState": (
        *("state", "demand_torque", "command", "intervention", "release", "limit", "refused_releases", VALID),
        *("law", "slip_set_point"),
    ),
    "friction_msgs/msg/SupervisorDebug": ("torque_set_point",),
    "friction_msgs/msg/Grip": (
        *(f"{part}.{name}" for part in ("vehicle", "front", "rear") for name in ("mu_x", "mu_used", "mu_used_stddev")),
        *("distance", "mu_proven", "mu_lower", "mu_upper", "evidence", VALID),
    ),
    "friction_msgs/msg/WheelGrip": ("used.mu_x", "used.mu_used", "used.mu_used_stddev", "mu_proven", VALID),
    "friction_msgs/msg/VehicleFit": ("brakings", VALID),
    "friction_msgs/msg/ContactPatch": ("length", "shift", VALID),
    "friction_msgs/msg/TyreForce": ("fx", "fz", "fx_stddev", "fz_stddev", VALID),
    "friction_msgs/msg/BrakeCommand": ("command",),
    "friction_msgs/msg/BrakeDemand": ("pressure",),
    "sensor_msgs/msg/FluidPressure": ("fluid_pressure",),
    "sensor_msgs/msg/NavSatFix": ("latitude", "longitude", "status.status"),
    "geometry_msgs/msg/TwistWithCovarianceStamped": ("twist.twist.linear.x",),
}


@dataclass(frozen=True)
class CrossingEvent:
    """A change of the slope's sign, estimated or true."""

    time: float
    """When an estimated crossing was known, the stamp of the first message with it, or when a true one was [s]."""
    sign: int
    """Sign after the crossing: -1 the peak was passed, +1 the stable side was regained."""
    slip: float
    """Slip at the crossing [-], compensated for delay: an estimate of lambda_max."""


@dataclass
class Series:
    """The messages of one topic: the time of their stamps and some of their fields."""

    time: Array
    """Time since the start of the run [s]."""
    columns: Mapping[str, Array]
    reasons: Counter[str] = field(default_factory=Counter)
    """How often each reason was given where a message was not valid: in the order of WHY; … for numbers that vary."""

    def __getitem__(self, column: str) -> Array:
        """Return a field over time."""
        return self.columns[column]


@dataclass
class RecordedRun:
    """A run, of the messages in a bag or of those that estimators make of one."""

    wheels: tuple[str, ...]
    """Names of the wheels of the car."""
    start: int
    """First stamp of wheel_states, or of anything where there is none [ns]."""
    series: Mapping[str, Series]
    """Series by topic, without the namespace."""
    samples: Array
    """Time [s] of each message of wheel_states."""
    notes: Mapping[str, str] = field(default_factory=dict)
    """Notes of the bag."""
    problems: tuple[str, ...] = ()
    """What could not be read."""
    not_read: tuple[str, ...] = ()
    """Topics of the bag that are not among the series; those without a message are marked."""

    def get(self, topic: str) -> Series | None:
        """Return the series of a topic, None where the bag has no message of it."""
        return self.series.get(topic)

    def places(self) -> Places:
        """Return the places of the drive: of the receiver that has most fixes."""
        receivers = [each for each in self.series.values() if {"latitude", "longitude"} <= each.columns.keys()]
        most = max(receivers, key=lambda each: each.time.size, default=None)
        if most is None:
            return Places(np.empty(0, np.int64), np.empty(0), np.empty(0))
        stamps = self.start + np.round(most.time * NANOSECONDS).astype(np.int64)
        return places_of(stamps, most["latitude"], most["longitude"], most["status.status"])

    def crossings(self, topic: str) -> list[CrossingEvent]:
        """Return the slope crossings of a friction_slope topic; times as in the truth, or when first known."""
        series = self.get(topic)
        if series is None:
            return []
        seconds, nanoseconds = series["crossing_stamp.sec"], series["crossing_stamp.nanosec"]
        rows = np.flatnonzero(np.diff(series["crossings"], prepend=0.0) > 0.0)
        compensated = (seconds - self.start // NANOSECONDS) + (nanoseconds - self.start % NANOSECONDS) / NANOSECONDS
        time = compensated if topic.startswith("truth/") else series.time
        return [
            CrossingEvent(float(time[row]), int(series["crossing_sign"][row]), float(series["slip_at_crossing"][row]))
            for row in rows
        ]
