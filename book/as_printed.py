"""(8.4) and (8.5) as printed: H times the sign of the slip rate or of eta, one negative threshold, no dead zones.

Shipped is what friction_slope makes of them. This is here to show which of the chapter's mean slips at detection the
printed equations give, and by which choice of what the chapter leaves open.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from friction_msgs.msg import WheelSlip
from numpy.typing import NDArray

from benchmarks.protocol import ACCELERATION_STDDEV, BRAKE_GAIN, CAR, CORNER
from benchmarks.slope.detection import METHODS, Run, sensor_messages
from corner_sim.sensors import CHAPTER_NOISE
from friction_runtime.stamps import to_nanoseconds
from friction_slope.estimate import SlopeSample
from friction_slope.signals import SignalWindow
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Printed:
    """What the chapter leaves to tuning."""

    window: int
    """Samples of the fits that give H, slip rate and eta; the slip is read at its centre, too."""
    least_torque: float
    """T-bar: nothing is detected below this brake torque [N m]."""
    h_instability: float = -15.0
    """[rad/s^3]"""


VARIANTS = (Printed(28, 100.0), Printed(28, 30.0), Printed(16, 100.0))
"""The quietest window that keeps up with the manoeuvre, with a threshold of torque above the noise of H and with one at
the onset; and a window in whose noise H falls below the threshold before the peak."""


def slips_at_detection(run: Run, variants: Sequence[Printed], slip: WheelSlipParameters, seed: int) -> Array:
    """Slip at the first detection [-] by each variant and method, shape (variants, 2); NaN where there is none."""
    samples = _samples(run, slip, seed)
    found = np.full((len(variants), len(METHODS)), np.nan)
    for row, variant in zip(found, variants, strict=True):
        window = SignalWindow(CORNER.inertia, variant.window, variant.window, 0.0)
        for sample in samples:
            window.update(sample, sample.slip)
            if not window.ready or sample.brake_torque < variant.least_torque:
                continue
            growing = np.sign([window.slip_rate(), -window.wheel_acceleration()])
            detected = np.isnan(row) & (growing * window.h() <= variant.h_instability)
            row[detected] = window.slip()
    return found


def _samples(run: Run, parameters: WheelSlipParameters, seed: int) -> list[SlopeSample]:
    """Measured wheel speed and torque, with slip and slip rate by the shipped wheel_slip."""
    car = CarProcessor(CAR, parameters)
    samples = []
    for messages in sensor_messages(run, CHAPTER_NOISE, ACCELERATION_STDDEV, seed):
        inputs: dict[str, Any] = dict(messages)
        (torque,) = (m.fluid_pressure * BRAKE_GAIN for t, m in messages if t.endswith("brake_pressure"))
        answers = [a for t, m in messages if t in car.sensors for _, a in car.process(t, m)]
        (estimate,) = (answer for answer in answers if isinstance(answer, WheelSlip))
        wheel = inputs["wheel_states"]
        stamp = to_nanoseconds(wheel.header.stamp)
        samples.append(SlopeSample(stamp, wheel.velocity[0], torque, estimate.slip, estimate.slip_rate))
    return samples
