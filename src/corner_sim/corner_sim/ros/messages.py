"""Sensor and truth messages from a sample of the plant."""

from array import array
from collections.abc import Sequence
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from builtin_interfaces.msg import Time
from friction_msgs.msg import BrakeDemand, FrictionCurve, FrictionSlope, TyreForce, TyreSignals, WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped, WrenchStamped
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header

from corner_sim.plant import SLIP_MIN_SPEED, PlantSample, SlopeCrossings
from corner_sim.sensors import TYRE_SAMPLE_RATE, Measurement, SensorNoise
from friction_runtime.messages import from_nanoseconds, validity
from friction_runtime.processor import Output
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

if TYPE_CHECKING:
    from corner_sim.smart_tyre.tyre_signal import TyreBlock

BASE_FRAME = "base_link"
_YAW_MOMENT = "truth/yaw_moment"
_STANDING = f"slip is not defined at or below {SLIP_MIN_SPEED} m/s"


def topics(
    wheels: Sequence[str], vehicle_velocity: bool, brake_demand: bool, tyre_signals: bool, yaw_moment: bool = False
) -> dict[str, type]:
    """Return the topics that the plant publishes, with their types."""
    given: dict[str, type] = {
        "wheel_states": JointState,
        "imu/data": Imu,
        "truth/vehicle_velocity": TwistWithCovarianceStamped,
    }
    if vehicle_velocity:
        given["vehicle_velocity"] = TwistWithCovarianceStamped
    if brake_demand:
        given["brake_demand"] = BrakeDemand
    if yaw_moment:
        given[_YAW_MOMENT] = WrenchStamped
    for wheel in wheels:
        given[f"{wheel}/brake_pressure"] = FluidPressure
        if tyre_signals:
            given[f"{wheel}/tyre_signals"] = TyreSignals
        given[f"truth/{wheel}/slip"] = WheelSlip
        given[f"truth/{wheel}/friction_slope"] = FrictionSlope
        given[f"truth/{wheel}/friction_curve"] = FrictionCurve
        given[f"truth/{wheel}/tyre_force"] = TyreForce
    return given


def is_truth(topic: str) -> bool:
    """Whether a topic holds true values of the plant, which no car has."""
    return topic.startswith("truth/")


def wheel_states(stamp: Time, joints: Sequence[str], measured: Measurement) -> JointState:
    """Make the wheel encoders' message."""
    return JointState(header=Header(stamp=stamp), name=list(joints), velocity=measured.wheel_speed.tolist())


def brake_pressure(stamp: Time, wheel: str, pressure: float, variance: float) -> FluidPressure:
    """Make one wheel's pressure [Pa] message, with its variance [Pa^2]."""
    return FluidPressure(header=Header(stamp=stamp, frame_id=wheel), fluid_pressure=pressure, variance=variance)


def imu(stamp: Time, acceleration: float, variance: float, axis: str = "x") -> Imu:
    """Make the message of an accelerometer: one axis [m/s^2], no orientation, no rates (marked in the covariances)."""
    message = Imu(header=Header(stamp=stamp, frame_id=BASE_FRAME))
    setattr(message.linear_acceleration, axis, acceleration)
    message.linear_acceleration_covariance[4 * "xyz".index(axis)] = variance
    message.orientation_covariance[0] = -1.0
    message.angular_velocity_covariance[0] = -1.0
    return message


def velocity(stamp: Time, speed: float, variance: float) -> TwistWithCovarianceStamped:
    """Make a vehicle speed [m/s] message, with its variance [m^2/s^2]."""
    message = TwistWithCovarianceStamped(header=Header(stamp=stamp, frame_id=BASE_FRAME))
    message.twist.twist.linear.x = speed
    message.twist.covariance[0] = variance
    return message


def brake_demand(stamp_ns: int, pressure: float) -> BrakeDemand:
    """Make the driver's demand [Pa] message, for all wheels."""
    return BrakeDemand(header=Header(stamp=from_nanoseconds(stamp_ns), frame_id=BASE_FRAME), pressure=pressure)


def sensors(
    stamp_ns: int, vehicle: Vehicle, measured: Measurement, noise: SensorNoise, acceleration_variance: float
) -> list[Output]:
    """Make the messages of all sensors of a vehicle for one sample: vehicle, wheels, then pressures."""
    stamp = from_nanoseconds(stamp_ns)
    outputs: list[Output] = [
        ("vehicle_velocity", velocity(stamp, measured.speed, noise.speed_variance)),
        ("imu/data", imu(stamp, measured.acceleration, acceleration_variance, vehicle.accelerometer.axis)),
    ]
    for wheel, pressure in zip(vehicle.wheels, measured.brake_pressure, strict=True):
        variance = noise.torque_variance / wheel.brake_gain**2
        message = brake_pressure(stamp, wheel.name, float(pressure), variance)
        outputs.append((f"{wheel.name}/brake_pressure", message))
    outputs.append(("wheel_states", wheel_states(stamp, vehicle.joints, measured)))
    return outputs


def tyre_signals(
    stamp_ns: int, wheels: Sequence[str], blocks: Sequence["TyreBlock"], inflation_pressure: float
) -> list[Output]:
    """Make the messages of the smart tyres; `stamp_ns` is that of the first sample of the blocks."""
    stamp = from_nanoseconds(stamp_ns)
    return [
        (
            f"{wheel}/tyre_signals",
            TyreSignals(
                header=Header(stamp=stamp, frame_id=wheel),
                wheel=wheel,
                sample_rate=TYRE_SAMPLE_RATE,
                first_sample=block.first_sample,
                encoder_voltage=array("f", block.encoder_voltage.tobytes()),
                radial_acceleration=array("f", block.radial_acceleration.tobytes()),
                inflation_pressure=inflation_pressure,
            ),
        )
        for wheel, block in zip(wheels, blocks, strict=True)
        if not block.lost
    ]


def truth(stamp_ns: int, wheels: Sequence[str], sample: PlantSample, crossings: SlopeCrossings) -> list[Output]:
    """Make the messages of the truth for one sample."""
    stamp = from_nanoseconds(stamp_ns)
    outputs: list[Output] = [("truth/vehicle_velocity", velocity(stamp, sample.speed, 0.0))]
    if isfinite(sample.yaw_moment):
        moment = WrenchStamped(header=Header(stamp=stamp, frame_id=BASE_FRAME))
        moment.wrench.torque.z = sample.yaw_moment
        outputs.append((_YAW_MOMENT, moment))
    for i, wheel in enumerate(wheels):
        header = _header(stamp, wheel)
        outputs.append((f"truth/{wheel}/slip", _slip(header, wheel, sample, i)))
        outputs.append((f"truth/{wheel}/friction_slope", _slope(header, wheel, sample, crossings, i)))
        outputs.append((f"truth/{wheel}/friction_curve", _curve(header, wheel, sample, crossings, i)))
        outputs.append((f"truth/{wheel}/tyre_force", _force(header, wheel, sample, i)))
    return outputs


def _slip(header: Header, wheel: str, sample: PlantSample, i: int) -> WheelSlip:
    moving = sample.speed > SLIP_MIN_SPEED
    return WheelSlip(
        header=header,
        wheel=wheel,
        slip=float(sample.slip[i]) if moving else nan,
        slip_rate=float(sample.slip_rate[i]),
        vehicle_speed=sample.speed,
        wheel_speed=float(sample.wheel_speed[i]),
        slip_stddev=0.0,
        slip_rate_stddev=0.0,
        vehicle_speed_stddev=0.0,
        speed_measured=True,
        validity=_validity(wheel, moving),
    )


def _slope(header: Header, wheel: str, sample: PlantSample, crossings: SlopeCrossings, i: int) -> FrictionSlope:
    moving = sample.speed > SLIP_MIN_SPEED
    count = int(crossings.count[i])
    return FrictionSlope(
        header=header,
        wheel=wheel,
        method="truth",
        sign=int(np.sign(sample.slope[i])) if moving else 0,
        probability_beyond_peak=float(sample.tyre_slip[i] > sample.peak[i][0]) if moving else nan,
        h=float(sample.h[i]),
        indicator=float(sample.h[i] * np.sign(sample.slip_rate[i])),
        delay=0.0,
        crossings=count,
        crossing_sign=int(crossings.sign[i]) if count else 0,
        slip_at_crossing=float(crossings.slip[i]),
        crossing_stamp=from_nanoseconds(int(crossings.stamp[i])),
        validity=_validity(wheel, moving),
    )


def _curve(header: Header, wheel: str, sample: PlantSample, crossings: SlopeCrossings, i: int) -> FrictionCurve:
    theta = sample.theta[i]
    lambda_max, mu_max = (float(value) for value in sample.peak[i])
    slip = float(sample.tyre_slip[i])
    return FrictionCurve(
        header=header,
        wheel=wheel,
        method="truth",
        theta_1=float(theta[0]),
        theta_2=float(theta[1]),
        theta_3=float(theta[2]),
        lambda_max=lambda_max,
        mu_max=mu_max,
        theta_covariance=np.zeros(9),
        lambda_max_stddev=0.0,
        mu_max_stddev=0.0,
        slip=slip,
        mu=float(sample.friction[i]),
        slope=float(sample.slope[i]),
        slope_stddev=0.0,
        probability_beyond_peak=float(slip > lambda_max),
        samples=sample.index + 1,
        restarts=int(crossings.surface_changes[i]),
        validity=validity(wheel, Reason.OK, ""),
    )


def _force(header: Header, wheel: str, sample: PlantSample, i: int) -> TyreForce:
    load = float(sample.vertical_load[i])
    return TyreForce(
        header=header,
        wheel=wheel,
        fx=-load * float(sample.friction[i]),
        fz=load,
        fx_stddev=0.0,
        fz_stddev=0.0,
        validity=validity(wheel, Reason.OK, ""),
    )


def _validity(wheel: str, moving: bool) -> Any:
    return validity(wheel, Reason.OK, "") if moving else validity(wheel, Reason.LOW_SPEED, _STANDING)


def _header(stamp: Time, frame_id: str) -> Header:
    return Header(stamp=stamp, frame_id=frame_id)
