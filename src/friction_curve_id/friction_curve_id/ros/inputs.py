"""Inputs of a method as a processor uses them, and how messages are read."""

from collections.abc import Mapping, Sequence
from typing import Any, Final, Protocol

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped

from friction_curve_id.interface import CurveEstimate, Refusal
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.messages import slip_is_known, speed_is_known, to_nanoseconds
from vehicle_models.physical_bounds import HIGHEST_SPEED

VEHICLE_VELOCITY: Final = "vehicle_velocity"
IMU: Final = "imu/data"
SPEED_SENSOR_GAP: Final = 0.3
"""vehicle_velocity is interpolated over up to this time [s], whatever max_gap is: GNSS runs at 10 or 5 Hz."""
Reading = tuple[int, tuple[float, ...]]
"""Content of a message of an aligned input: time [ns] and values."""


class CurveInputs(Protocol):
    """A method with its inputs: one stream that triggers estimates, others aligned to it."""

    @property
    def primary(self) -> str:
        """Topic that triggers estimates."""
        ...

    @property
    def sensors(self) -> Mapping[str, type]:
        """Topics with sensor QoS, the primary among them or not."""
        ...

    @property
    def estimates(self) -> Mapping[str, type]:
        """Topics with reliable QoS."""
        ...

    @property
    def aligned(self) -> Sequence[AlignedInput]:
        """Inputs aligned to the primary."""
        ...

    def read_primary(self, message: Any) -> Any:
        """Return the payload of a message of the primary."""
        ...

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return the content of a message of an aligned input, or why it is refused."""
        ...

    def answer(self, sample: AlignedSample[Any]) -> tuple[CurveEstimate | Refusal, float]:
        """Return the estimator's answer, and the present slip [-] from the inputs (NaN: only the estimate has it)."""
        ...

    def reset(self) -> None:
        """Reset the estimator."""
        ...


def vehicle_velocity(message: TwistWithCovarianceStamped) -> Reading | str:
    """Return the speed [m/s] and 1, or why there is none."""
    speed = message.twist.twist.linear.x
    if not abs(speed) <= HIGHEST_SPEED:
        return f"{VEHICLE_VELOCITY}: {speed} is not a vehicle speed"
    return to_nanoseconds(message.header.stamp), (float(speed), 1.0)


def wheel_slip(message: WheelSlip) -> Reading:
    """Return vehicle speed [m/s] and 1 (0 and 0 where unknown), slip [-] and 1 (0 and 0 where not valid)."""
    speed = (float(message.vehicle_speed), 1.0) if speed_is_known(message) else (0.0, 0.0)
    slip = (float(message.slip), 1.0) if slip_is_known(message) else (0.0, 0.0)
    return to_nanoseconds(message.header.stamp), speed + slip


def known_speed(sample: AlignedSample[Any], topic: str) -> float | None:
    """Return the vehicle speed [m/s] from `topic` at the stamp, None where it is unknown there or around it."""
    values = sample.values.get(topic)
    return values[0] if values is not None and values[1] == 1.0 else None
