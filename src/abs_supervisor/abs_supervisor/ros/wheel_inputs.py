"""Inputs of the supervisor of one wheel from messages: speeds, slip, pressure, friction curve, motion of the car."""

from collections import deque
from collections.abc import Mapping
from math import inf, isfinite, isnan, nan
from typing import Any, Final

from friction_msgs.msg import FrictionCurve, SlopeVote, WheelSlip
from sensor_msgs.msg import FluidPressure, Imu, JointState

from abs_supervisor.curve_selector import CurveReport, Estimate
from abs_supervisor.measurements import Measurements
from abs_supervisor.road_curve import RoadCurve, curve_through
from abs_supervisor.speed_probe import CURVE_LATERAL, CURVE_YAW_RATE
from friction_runtime.aligner import AlignedSample
from friction_runtime.messages import speed_is_known, to_nanoseconds
from friction_runtime.processor import Report, silent
from friction_runtime.reports import of_topic
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from vehicle_models.physical_bounds import HIGHEST_SLIP
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

BRAKE_DEMAND: Final = "brake_demand"
IMU: Final = "imu/data"
_TEXTS: Final = 20
"""Changes of the reason of a slip that are kept: a sample waits for its inputs far less long."""
_CONSISTENT: Final = 0.02
"""[-] by which a slip may differ from that of the speeds in its message."""
_ESTIMATES: dict[int, Estimate] = {
    Reason.OK: Estimate.VALID,
    Reason.UNKNOWN_CAR: Estimate.VALID,
    Reason.PEAK_NOT_PASSED: Estimate.VAGUE,
    Reason.UNCERTAIN: Estimate.VAGUE,
    Reason.NO_EXCITATION: Estimate.QUIET,
    Reason.LOW_SPEED: Estimate.QUIET,
}
_OF_THE_TYRE = "car"
"""Method whose friction is that of the tyre."""
Reading = tuple[int, tuple[float, ...]]


class WheelInputs:
    """Reads the messages of one wheel."""

    def __init__(self, wheel: str, vehicle: Vehicle, report: Report, fine: bool) -> None:
        """Choose a wheel of the car; messages without its speed go to `report`.

        With `fine`, as slip control needs it, an uncertain slip counts with its standard deviation,
        and the motion of the car in a curve is read.
        """
        self._fine = fine
        self.brake = BrakeTorque(vehicle, wheel)
        self.slip, self.curve = f"{wheel}/slip", f"{wheel}/friction_curve"
        self.pressure = self.brake.topic
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self.pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {self.slip: WheelSlip, self.curve: FrictionCurve}
        if fine:
            self.sensors = {**self.sensors, IMU: Imu}
        self._across = "x" if vehicle.accelerometer.axis == "y" else "y"
        self._index = vehicle.wheel_names.index(wheel)
        self._radii = vehicle.radii
        # Reports on the other wheels are left to the processors of these.
        self._own = WheelSpeeds(vehicle, (wheel,), report)
        self._all = WheelSpeeds(vehicle, vehicle.wheel_names, silent)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._slip_texts: deque[tuple[int, str]] = deque(maxlen=_TEXTS)

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return stamp [ns] and values of a message for the aligner, or why it is refused.

        Validity travels as a number, so that an interpolation between a known and an unknown value is unknown.
        """
        if topic == self.pressure:
            read = self.brake.read(message)
            return read if isinstance(read, str) else (read[0], (read[1],))
        stamp = to_nanoseconds(message.header.stamp)
        if topic == BRAKE_DEMAND:
            torque = self.brake.torque(topic, message.pressure)
            return torque if isinstance(torque, str) else (stamp, (torque,))
        if topic == IMU:
            lateral = float(getattr(message.linear_acceleration, self._across))
            turns = abs(lateral) > CURVE_LATERAL or abs(message.angular_velocity.z) > CURVE_YAW_RATE
            return stamp, (float(turns),)
        if topic == WHEEL_STATES:
            speeds = self._all.read(message)
            if not isfinite(speeds[self._index]):
                self._own.read(message)  # reports why
            return stamp, tuple(each for speed in speeds for each in _flagged(speed))
        slip, stddev, speed = message.slip, message.slip_stddev, message.vehicle_speed
        turns = self._radii[self._index] * message.wheel_speed / speed if speed > 0.0 else nan
        if not message.validity.valid:
            self._keep_text(stamp, message.validity.text)
            slip = nan
            uncertain = self._fine and message.validity.reason == Reason.UNCERTAIN
            if uncertain and speed > 0.0 and speed_is_known(message):  # here its error is weighed
                slip, stddev = 1.0 - turns, message.vehicle_speed_stddev * abs(turns / speed)
        elif abs(1.0 - turns - slip) > _CONSISTENT:
            self._keep_text(stamp, f"{slip:.3f} contradicts the speeds in the same message")
            slip = nan
        known = abs(slip) <= HIGHEST_SLIP and 0.0 <= stddev <= HIGHEST_SLIP
        car = _flagged(speed if speed_is_known(message) else nan)
        doubt = message.vehicle_speed_stddev if car[1] and message.vehicle_speed_stddev < inf else 0.0
        measured = float(message.speed_measured)
        inertial = float(message.speed_measured or not isnan(message.accelerometer_wrong_probability))
        return stamp, (*_flagged(slip if known else nan), stddev if known else 0.0, *car, measured, inertial, doubt)

    def _keep_text(self, stamp: int, text: str) -> None:
        """Keep why a slip is not valid, from a stamp [ns] on: a sample gets what holds for it, not the last."""
        if self._slip_texts and stamp < self._slip_texts[-1][0]:
            self._slip_texts.clear()
        if not self._slip_texts or self._slip_texts[-1][1] != text:
            self._slip_texts.append((stamp, text))

    def _slip_text(self, stamp: int) -> str:
        for since, text in reversed(self._slip_texts):
            if since <= stamp:
                return text or "not valid"
        return "not valid"

    def knows_wheel(self, topic: str, values: tuple[float, ...]) -> bool:
        """Whether the values that were read from a topic say something of this wheel: its own speed may be missing."""
        return topic != WHEEL_STATES or values[2 * self._index + 1] == 1.0

    def observe(self, sample: AlignedSample[SlopeVote], demand: float) -> Measurements:
        """Return what is known at the stamp of a sample, with the driver's demand [N m], NaN where unknown."""
        own = nan
        others: list[float] = []
        flagged = sample.values.get(WHEEL_STATES, ())
        for index in range(len(flagged) // 2):
            if flagged[2 * index + 1] != 1.0:
                continue
            if index == self._index:
                own = flagged[2 * index]
            else:
                others.append(flagged[2 * index] * self._radii[index])
        slip, known, stddev, car, car_known, measured, inertial, doubt = sample.values.get(self.slip, (0.0,) * 8)
        text = ""
        if known != 1.0:
            slip, text = nan, sample.missing.get(self.slip) or of_topic(self.slip, self._slip_text(sample.stamp))
        return Measurements(
            wheel_speed=own,
            demand=demand,
            others=others,
            torque=sample.values.get(self.pressure, (nan,))[0],
            slip=slip,
            slip_stddev=stddev if known == 1.0 else nan,
            car_speed=car if car_known == 1.0 else nan,
            car_speed_stddev=doubt if car_known == 1.0 else nan,
            car_speed_measured=measured == 1.0,
            inertial=inertial == 1.0,
            in_curve=sample.values.get(IMU, (0.0,))[0] > 0.0,
            slip_text=text,
        )


def _flagged(value: float) -> tuple[float, float]:
    """Return a value and whether it is known, for the aligner."""
    return (value, 1.0) if isfinite(value) else (0.0, 0.0)


def curve_report(message: FrictionCurve) -> CurveReport:
    """Return the report of a message: without a curve where its parameters are none."""
    estimate = _ESTIMATES.get(message.validity.reason, Estimate.NONE)
    curve = None
    if estimate in (Estimate.VALID, Estimate.VAGUE):
        try:
            curve = _curve(message)
        except ValueError:
            estimate = Estimate.NONE
    return CurveReport(
        to_nanoseconds(message.header.stamp),
        estimate,
        curve,
        message.lambda_max_stddev,
        message.probability_beyond_peak,
        message.samples,
        message.restarts,
        message.method == _OF_THE_TYRE,
        message.slip,
        message.slip_stddev,
    )


def _curve(message: FrictionCurve) -> RoadCurve:
    if isnan(message.theta_1):
        # A method may know the peak by another family than Burckhardt's, and its height not yet.
        mu_max = message.mu_max
        if not isfinite(mu_max):
            share = curve_through(message.lambda_max, 1.0).friction(message.slip)
            mu_max = message.mu / share if share > 0.0 else nan
        return curve_through(message.lambda_max, mu_max)
    return RoadCurve(message.theta_1, message.theta_2, message.theta_3, message.lambda_max)
