"""The shipped processors wheel_slip and friction_slope, by both methods, over one run."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from friction_msgs.msg import FrictionSlope
from numpy.typing import NDArray

from benchmarks.protocol import ACCELERATION_STDDEV, CAR, WHEEL
from benchmarks.slope.runs import Run, sensor_messages
from friction_parameters.parameter import changed
from friction_runtime.processor import Output
from friction_slope.parameters import SHIPPED, FrictionSlopeParameters
from friction_slope.ros.processor import WheelProcessor
from vehicle_models.sensor_noise import SensorNoise
from vehicle_models.vehicle import Vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]

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
