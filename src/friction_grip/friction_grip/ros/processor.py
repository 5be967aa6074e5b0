"""Wheel speeds, accelerometer, pressures and curves in, grip of car and wheels out, every 0.05 s."""

from collections.abc import Mapping
from math import hypot, isfinite, nan
from statistics import median
from typing import Any, Final

from friction_msgs.msg import FrictionCurve, Grip, GripUsed, TyreForce, WheelGrip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_grip.friction_used import UNKNOWN, FrictionUsed, GripInUse, Used
from friction_grip.parameters import FrictionGripParameters
from friction_grip.road_memory import Proof, Proofs, RoadMemory
from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.lateral_inputs import yaw_rate_of
from friction_runtime.messages import header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

GRIP: Final = "grip"
IMU: Final = "imu/data"
VEHICLE_SPEED: Final = "vehicle_speed"
_SPEED_KNOWN: Final = 1.0
"""Largest deviation of a speed of which distances are made [m/s]."""
_LONGEST_STEP: Final = 0.5
"""Time between samples over which a car is known to have gone on [s]."""
_REVOLUTION: Final = 0.5
"""Longest time between two forces of a smart tyre [s], which come once a revolution."""
_LARGEST: Final = 100.0
"""Acceleration that no accelerometer of a car reads [m/s^2]."""
_PASSED: Final = (Reason.UNCERTAIN, Reason.NO_EXCITATION)
"""Of a curve whose lambda_max is not known: its mu_max may be, of a braking, or of driven wheels that spin."""
Speeds = tuple[float, ...]


class GripProcessor(AlignedProcessor[Speeds]):
    """Layer 2 of friction_grip: fires on wheel_states."""

    def __init__(self, vehicle: Vehicle, parameters: FrictionGripParameters, report: Report = silent) -> None:
        """Build for a vehicle; `report` is the log function."""
        self._p = parameters
        self._radii = vehicle.radii
        self._mounting = vehicle.accelerometer
        self._across = "x" if vehicle.accelerometer.axis == "y" else "y"
        self._wheel_speeds = WheelSpeeds(vehicle, vehicle.wheel_names, report)
        self._brakes = {(brake := BrakeTorque(vehicle, name)).topic: brake for name in vehicle.wheel_names}
        self._curves = tuple(f"{name}/friction_curve" for name in (*vehicle.wheel_names, "vehicle"))
        self._forces = tuple(f"{name}/tyre_force" for name in vehicle.wheel_names)
        self.sensors: Mapping[str, type] = {
            WHEEL_STATES: JointState,
            IMU: Imu,
            **dict.fromkeys(self._brakes, FluidPressure),
        }
        self.estimates: Mapping[str, type] = {
            **dict.fromkeys(self._curves, FrictionCurve),
            **dict.fromkeys(self._forces, TyreForce),
            VEHICLE_SPEED: TwistWithCovarianceStamped,
        }
        self._names = vehicle.wheel_names
        self._grips = tuple(f"{name}/grip" for name in self._names)
        self.outputs: Mapping[str, type] = {GRIP: Grip, **dict.fromkeys(self._grips, WheelGrip)}
        others = (*self._brakes, *self.estimates)
        aligned = [AlignedInput(topic) for topic in (IMU, *self._brakes, VEHICLE_SPEED)]
        aligned += [AlignedInput(topic, optional=True) for topic in self._curves]
        aligned += [AlignedInput(topic, _REVOLUTION, optional=True) for topic in self._forces]
        super().__init__("vehicle", Primary(WHEEL_STATES, "vehicle", report), aligned, parameters.deadline, others)
        self._used = FrictionUsed(vehicle)
        tail = 1.0 - parameters.lower_probability
        self._road = RoadMemory(parameters.prior, parameters.change_distance, parameters.proof_distance, tail)
        self._of_wheels = [Proofs(parameters.proof_distance) for _ in self._names]
        self._forget()

    def _forget(self) -> None:
        self._used.reset()
        for proofs in self._of_wheels:
            proofs.reset()
        self._road.reset()
        self._last: int | None = None
        self._has_lateral = False
        self._message: Grip | None = None

    def _start_again(self, stamp: int) -> None:
        self._forget()

    def _payload(self, message: JointState) -> Speeds:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Any) -> str | None:
        stamp = to_nanoseconds(message.header.stamp)
        if topic == IMU:
            forward = self._mounting.forward(message.linear_acceleration)
            leftward = float(getattr(message.linear_acceleration, self._across))
            if not (abs(forward) <= _LARGEST and abs(leftward) <= _LARGEST):
                return f"{IMU}: {forward} and {leftward} m/s^2 are no accelerations of a car"
            yaw_rate = yaw_rate_of(message)
            turning = (yaw_rate, 1.0) if isfinite(yaw_rate) else (0.0, 0.0)
            return self._aligner.offer(topic, stamp, (forward, leftward, *turning))
        if topic == VEHICLE_SPEED:
            speed, variance = message.twist.twist.linear.x, message.twist.covariance[0]
            known = isfinite(speed) and 0.0 <= variance <= _SPEED_KNOWN**2
            return self._aligner.offer(topic, stamp, (speed, 1.0) if known else (0.0, 0.0))
        brake = self._brakes.get(topic)
        if topic in self._forces:
            return self._aligner.offer(topic, stamp, _of_tyre(message))
        if brake is None:
            known = message.validity.valid or message.validity.reason in _PASSED
            values = (message.mu_max, message.mu_max_stddev, 1.0) if known else (0.0, 0.0, 0.0)
            return self._aligner.offer(topic, stamp, values if all(map(isfinite, values)) else (0.0, 0.0, 0.0))
        reading = brake.read(message)
        return reading if isinstance(reading, str) else self._aligner.offer(topic, reading[0], (reading[1],))

    def _fire(self, sample: AlignedSample[Speeds]) -> list[Output]:
        speeds = [speed * radius for speed, radius in zip(sample.payload, self._radii, strict=True) if isfinite(speed)]
        imu = sample.values.get(IMU)
        step = 0.0 if self._last is None else (sample.stamp - self._last) / NANOSECONDS
        self._last = sample.stamp
        if not speeds:
            return self._unknown(sample.stamp, Reason.NO_WHEEL_SPEED, f"{WHEEL_STATES}: no wheel has a speed")
        # a wheel that brakes turns slower, one that drives faster: without an estimate the car has their median
        estimated = sample.values.get(VEHICLE_SPEED, (0.0, 0.0))
        speed = abs(estimated[0] if estimated[1] == 1.0 else median(speeds))
        self._road.drive(speed * min(step, _LONGEST_STEP))
        forward, leftward, yaw_rate, turning = (nan, nan, nan, 0.0) if imu is None else imu
        self._has_lateral = self._has_lateral or abs(leftward) > 0.0
        leftward, yaw_rate = leftward if self._has_lateral else nan, yaw_rate if turning == 1.0 else nan
        torques = [sample.values.get(topic, (nan,))[0] for topic in self._brakes]
        used = self._used.update(sample.stamp, speed, forward, leftward, yaw_rate, torques, sample.payload)
        if used is None:
            return []
        outputs = self._of_wheels_now(sample, used)
        if not isfinite(used.vehicle.mu_used):
            return [*self._unknown(sample.stamp, *_lacking(sample, IMU)), *outputs]
        curves = [values[:2] for topic in self._curves if (values := sample.values.get(topic)) and values[2] == 1.0]
        if curves:
            self._road.take_curve(median(mu for mu, _ in curves), max(stddev for _, stddev in curves))
        self._road.feel(used, sample.stamp)
        return [*self._of_car(sample.stamp, used), *outputs]

    def _of_wheels_now(self, sample: AlignedSample[Speeds], used: GripInUse) -> list[Output]:
        outputs: list[Output] = []
        for place, by_brake in enumerate(used.wheels):
            by_tyre = sample.values.get(self._forces[place], (0.0, 0.0, 0.0))
            if by_tyre[2] == 1.0:
                mu_x, stddev = by_tyre[:2]
                self._road.prove(abs(mu_x), stddev, sample.stamp)
                used_now, source, why = Used(mu_x, nan, abs(mu_x), stddev), WheelGrip.TYRE_FORCE, (Reason.OK, "")
            elif isfinite(by_brake.mu_used):
                used_now, source, why = by_brake, WheelGrip.BRAKE, (Reason.OK, "")
            else:
                used_now, source, why = (
                    by_brake,
                    WheelGrip.NONE,
                    _lacking(sample, f"{self._names[place]}/brake_pressure"),
                )
            outputs.append(self._of_wheel(sample.stamp, place, used_now, source, *why))
        return outputs

    def _of_wheel(self, stamp: int, place: int, used: Used, source: int, reason: Reason, text: str) -> Output:
        name, proofs, distance = self._names[place], self._of_wheels[place], self._road.distance
        proofs.add(used.mu_used, used.stddev, distance, stamp)
        message = WheelGrip(header=header_at(stamp, name), wheel=name, used=_message(used))
        _set_proof(message, proofs.largest(distance), distance, stamp)
        message.source = source
        message.validity = validity(name, reason, text)
        return self._grips[place], message

    def _of_car(self, stamp: int, used: GripInUse) -> list[Output]:
        bounds = self._road.bounds()
        message = self._blank(stamp)
        message.vehicle, message.front, message.rear = map(_message, (used.vehicle, used.front, used.rear))
        _set_proof(message, self._road.proof(), self._road.distance, stamp)
        message.mu_lower, message.mu_upper = bounds.lower, bounds.upper
        message.margin = bounds.lower - max(used.vehicle.mu_used, used.front.mu_used, used.rear.mu_used)
        message.evidence = Grip.CURVE if bounds.has_curve else Grip.FORCE if bounds.has_proof else Grip.PRIOR
        message.validity = validity("vehicle", Reason.OK, "")
        self._message = message
        return [(GRIP, message)]

    def _unknown(self, stamp: int, reason: Reason, text: str) -> list[Output]:
        """Return a message without friction in use; what the road has proven stays known."""
        message = self._blank(stamp)
        message.validity = validity("vehicle", reason, text)
        self._message = message
        return [(GRIP, message)]

    def _blank(self, stamp: int) -> Grip:
        message = Grip(header=header_at(stamp, "base_link"), distance=self._road.distance)
        for name in ("mu_proven", "mu_proven_distance", "mu_proven_age", "mu_lower", "mu_upper", "margin"):
            setattr(message, name, nan)
        message.vehicle, message.front, message.rear = (_message(UNKNOWN) for _ in range(3))
        message.mu_lower_probability = self._p.lower_probability
        message.change_distance = self._p.change_distance
        return message

    def _state(self) -> tuple[Level, str]:
        last = self._message
        if last is None or last.validity.valid:
            return Level.OK, ""
        return Level.WARN, last.validity.text

    def _values(self) -> dict[str, str]:
        last = self._message
        if last is None:
            return {}
        return {
            "friction used": f"{last.vehicle.mu_used:.3f}",
            "friction proven": f"{last.mu_proven:.3f}",
            "proven before [m]": f"{last.mu_proven_distance:.0f}",
            "lower bound": f"{last.mu_lower:.3f}",
        }


def _of_tyre(force: TyreForce) -> tuple[float, ...]:
    """Return the friction that a tyre uses along the car, its deviation and 1; zeros where it is not known."""
    if not (force.validity.valid and force.fz > 0.0):
        return 0.0, 0.0, 0.0
    mu = -force.fx / force.fz
    stddev = hypot(force.fx_stddev, mu * force.fz_stddev) / force.fz
    return (mu, stddev, 1.0) if isfinite(mu + stddev) else (0.0, 0.0, 0.0)


def _lacking(sample: AlignedSample[Speeds], topic: str) -> tuple[Reason, str]:
    """Return why a friction is not known, in words too: what it needs of `topic` is missing, else the accelerometer."""
    topic = topic if topic in sample.missing else IMU
    reason = Reason.NO_ACCELERATION if topic == IMU else Reason.NO_PRESSURE
    return reason, sample.missing.get(topic, f"{topic}: no sample within the last 0.2 s")


def _set_proof(message: Grip | WheelGrip, proof: Proof | None, distance: float, stamp: int) -> None:
    message.mu_proven = message.mu_proven_distance = message.mu_proven_age = nan
    if proof is not None:
        message.mu_proven = proof.mu
        message.mu_proven_distance = distance - proof.distance
        message.mu_proven_age = (stamp - proof.stamp) / NANOSECONDS


def _message(used: Used) -> GripUsed:
    return GripUsed(mu_x=used.mu_x, mu_y=used.mu_y, mu_used=used.mu_used, mu_used_stddev=used.stddev)


def build(parameters: FrictionGripParameters, vehicle: Vehicle, report: Report = silent) -> list[GripProcessor]:
    """Make the processors: one for the whole vehicle."""
    return [GripProcessor(vehicle, parameters, report)]
