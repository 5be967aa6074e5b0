"""Detection of the slope sign on one corner: manoeuvres through and below the peak, noise of every seed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from friction_msgs.msg import FrictionSlope
from numpy.typing import NDArray

from benchmarks.protocol import ACCELERATION_STDDEV, BRAKE_GAIN, CAR, CORNER, DT, SPEED, STEP, WHEEL, hold_torque
from corner_sim.corner import SingleCorner
from corner_sim.ros import messages
from corner_sim.sensors import Measurement, SensorNoise
from friction_parameters.parameter import changed
from friction_runtime.processor import Output
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface
from vehicle_models.vehicle import Vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]

_ROLLING = 0.4
"""Free rolling before the brake [s]."""
_RAMP = 0.25
"""[s]"""
_RELEASE_RATE = 5000.0
"""Fastest fall of torque [N m/s], that of the brake actuator."""
_AFTER = 0.15
"""Time after the slip has come back through the peak [s]."""


@dataclass(frozen=True)
class Run:
    """True history of a manoeuvre, arrays of shape (samples,)."""

    theta: Array
    time: Array
    """[s], first sample at one sample time."""
    wheel_speed: Array
    speed: Array
    torque: Array
    slip: Array

    @property
    def lambda_max(self) -> float:
        """Slip at the peak [-]."""
        return float(burckhardt.peak(self.theta)[0])

    @property
    def acceleration(self) -> Array:
        """v_dot [m/s^2]."""
        return np.asarray(-CORNER.gravity * burckhardt.friction(self.theta, self.slip))

    @property
    def wheel_acceleration(self) -> Array:
        """omega_dot [rad/s^2]."""
        moment = CORNER.radius * CORNER.vertical_load * burckhardt.friction(self.theta, self.slip)
        return np.asarray((moment - self.torque) / CORNER.inertia)

    @property
    def eta(self) -> Array:
        """Normalised wheel deceleration [-]."""
        return -self.wheel_acceleration * CORNER.radius / CORNER.gravity

    @property
    def slip_rate(self) -> Array:
        """[1/s]"""
        return ((1.0 - self.slip) * self.acceleration - CORNER.radius * self.wheel_acceleration) / self.speed

    def crossings(self) -> tuple[float, float]:
        """Times [s] at which the slip passes the peak upwards and downwards, interpolated; NaN where it does not."""
        beyond = self.slip > self.lambda_max
        times = [np.nan, np.nan]
        for which, change in enumerate((1, -1)):
            found = np.flatnonzero(np.diff(beyond.astype(int)) == change)
            if found.size:
                k = found[0]
                share = (self.lambda_max - self.slip[k]) / (self.slip[k + 1] - self.slip[k])
                times[which] = float(self.time[k] + share * DT)
        return times[0], times[1]


@cache
def through_the_peak(name: str) -> Run:
    """Ramp and hold of manoeuvre B until twice lambda_max, then release until shortly after the slip is back."""
    theta = surface(name)
    twice = 2.0 * float(burckhardt.peak(theta)[0])
    hold = float(hold_torque("B", theta, CORNER)[0])
    released = False
    back = 0

    def torque(time: float, last: float, slip: float) -> float | None:
        nonlocal released, back
        released = released or slip > twice
        back += released and slip < 0.5 * twice
        if back * DT > _AFTER:
            return None
        if released:
            return max(last - _RELEASE_RATE * DT, 0.0)
        return hold * min(max(time - _ROLLING, 0.0) / _RAMP, 1.0)

    return _simulate(theta, torque)


@cache
def below_the_peak(name: str, ratio: float, duration: float) -> Run:
    """Ramp over 0.25 s and hold at `ratio` of the peak torque for `duration` [s]: there is nothing to detect."""
    theta = surface(name)
    hold = ratio * float(CORNER.peak_torque(theta))

    def torque(time: float, _last: float, _slip: float) -> float | None:
        if time > _ROLLING + _RAMP + duration:
            return None
        return hold * min(max(time - _ROLLING, 0.0) / _RAMP, 1.0)

    return _simulate(theta, torque)


def _simulate(theta: Array, torque: Any) -> Run:
    corner = SingleCorner(CORNER, [SPEED])
    rows = [(DT, SPEED / CORNER.radius, SPEED, 0.0, 0.0)]
    while True:
        time, _, _, last, slip = rows[-1]
        end = torque(time + DT, last, slip)
        if end is None:
            return Run(theta, *np.array(rows).T)
        corner.step(last, end, theta, DT)
        rows.append((time + DT, float(corner.wheel_speed[0]), float(corner.speed[0]), end, float(corner.slip[0])))


def sensor_messages(run: Run, noise: SensorNoise, acceleration_stddev: float, seed: int) -> Iterator[list[Any]]:
    """The messages of every sample of a run: speed sensor, accelerometer, pressure, wheel speed; (topic, message)."""
    noises = np.random.default_rng(seed).standard_normal((4, run.time.size))
    wheel_speed = run.wheel_speed + np.sqrt(noise.wheel_speed_variance) * noises[0]
    torque = run.torque + np.sqrt(noise.torque_variance) * noises[1]
    speed = run.speed + np.sqrt(noise.speed_variance) * noises[2]
    acceleration = run.acceleration + acceleration_stddev * noises[3]
    for k in range(run.time.size):
        measured = Measurement(
            wheel_speed=wheel_speed[k : k + 1],
            brake_pressure=torque[k : k + 1] / BRAKE_GAIN,
            speed=float(speed[k]),
            acceleration=float(acceleration[k]),
        )
        yield messages.sensors((k + 1) * STEP, CAR, measured, noise, acceleration_stddev**2)


METHODS = ("slip", "no_slip")


@dataclass(frozen=True)
class Settings:
    """Parameters of the processors under test."""

    slip: WheelSlipParameters
    slope: FrictionSlopeParameters
    imu: bool

    def processors(self, vehicle: Vehicle, wheel: str) -> tuple[CarProcessor, dict[str, WheelProcessor]]:
        """Make wheel_slip of a car, and friction_slope of a wheel by each method."""
        car = CarProcessor(vehicle, self.slip if self.imu else replace(self.slip, use_imu=False))
        return car, {method: WheelProcessor(wheel, vehicle, replace(self.slope, method=method)) for method in METHODS}

    def exact(self) -> "Settings":
        """The shortest window, zero thresholds and dead zones: for signals without noise."""
        exact = {
            "detector.window": 3,
            "detector.rate_window": 3,
            "detector.h_instability": 0.0,
            "detector.h_stability": 0.0,
            "detector.slip_rate_dead_zone": 0.0,
            "detector.least_growth": 0.0,
            "no_slip.eta_margin": 0.0,
        }
        return replace(self, slope=changed(self.slope, exact))


@dataclass(frozen=True)
class Detection:
    """Result of one method in one run; NaN where it detected nothing."""

    lost: float
    """Stamp of the first message with sign -1 [s]."""
    slip: float
    """Slip at that crossing [-]."""
    regained: float
    """Stamp of the first message with sign +1 after that [s]."""
    signs: Array
    """Sign in each message, shape (samples,); 0 where not valid."""
    delay: float
    """Delay of the filter as published [s]."""


def detect(run: Run, settings: Settings, noise: SensorNoise, seed: int) -> dict[str, Detection]:
    """Drive the processors through a run; return the result of each method."""
    stddev = ACCELERATION_STDDEV if noise.wheel_speed_variance > 0.0 else 0.0
    return detections(sensor_messages(run, noise, stddev, seed), run.time, settings)


def detections(
    samples: Iterable[Sequence[Output]], time: Array, settings: Settings, vehicle: Vehicle = CAR, wheel: str = WHEEL
) -> dict[str, Detection]:
    """Feed the processors with the messages of each sample; return the result of each method.

    Args:
        samples: messages of the sensors, sample by sample.
        time: of the samples [s], shape (samples,).
        settings: parameters of the processors.
        vehicle: the car as they know it.
        wheel: the wheel that is judged.
    """
    car, slopes = settings.processors(vehicle, wheel)
    answers: dict[str, list[tuple[int, float, float]]] = {method: [] for method in slopes}
    for sample in samples:
        for topic, message in sample:
            inputs = [(topic, message)]
            if topic in car.sensors:
                inputs += car.process(topic, message)
            for method, slope in slopes.items():
                for name, given in inputs:
                    if name in slope.sensors or name in slope.estimates:
                        for _, answer in slope.process(name, given):
                            if isinstance(answer, FrictionSlope):
                                answers[method].append((answer.sign, answer.slip_at_crossing, answer.delay))
    return {method: _detection(np.array(each), time) for method, each in answers.items()}


def _detection(answers: Array, time: Array) -> Detection:
    # The answers carry the stamps of wheel_states: answer k belongs to sample k.
    time = time[: len(answers)]
    signs = answers[:, 0]
    lost = np.flatnonzero(signs < 0)
    first = lost[0] if lost.size else len(answers)
    regained = np.flatnonzero(signs[first:] > 0)
    return Detection(
        lost=float(time[first]) if lost.size else np.nan,
        slip=float(answers[first, 1]) if lost.size else np.nan,
        regained=float(time[first + regained[0]]) if regained.size else np.nan,
        signs=signs,
        delay=float(np.nanmax(answers[:, 2])),
    )


def shipped_settings(imu: bool) -> Settings:
    """Return the shipped parameters, with or without an accelerometer."""
    return Settings(SHIPPED_SLIP["wheel_slip"].parameters, SHIPPED["friction_slope"].parameters, imu)
