"""Teeth that an encoder lacks: a speed that falls for a moment once in every revolution.

A gap of m teeth among N makes a short dip whose harmonics all have the amplitude 2 m / N; a wheel that is out of round
has one of a few thousandths. Stretches of some revolutions are taken alone, as the angle is the integral of a speed
that is itself too low.
"""

import numpy as np

from vehicle_doctor.drive import Array, Drive
from vehicle_doctor.finding import Finding, Verdict
from vehicle_doctor.motion import Motion

_REVOLUTIONS = 5.0
_STRETCHES = 10
"""Least number of stretches."""
_SAMPLES = 5.0
"""Least number of samples in a revolution."""
_TOOTH = 0.5
"""Share of a tooth from which one is missing."""


def check(drive: Drive, motion: Motion) -> list[Finding]:
    """Return a finding for each wheel that lacks teeth."""
    found = []
    use = motion.moving & ~motion.braking
    for i, wheel in enumerate(drive.vehicle.wheels):
        missing = 0.5 * wheel.encoder_teeth * _once_a_revolution(motion, motion.rims[:, i], wheel.radius, use)
        if missing > _TOOTH:
            share = 100.0 * missing / wheel.encoder_teeth
            text = f"falls once in every revolution, as if it lacked {missing:.1f} of {wheel.encoder_teeth} teeth"
            text += f"; its radius then seems {share:.1f} % larger"
            remedy = "look at its encoder ring, or tell the sender of its gap"
            found.append(Finding("teeth", wheel.name, Verdict.WARN, text, missing, remedy=remedy))
    return found


def _once_a_revolution(motion: Motion, rim: Array, radius: float, use: np.ndarray) -> float:
    """Median over stretches of the amplitude at the frequency of the wheel, over its speed; 0 where it is not seen."""
    speed = np.where(use & np.isfinite(rim) & (rim > 0.0), rim, np.nan)
    angle = np.cumsum(np.nan_to_num(speed)) * motion.step / radius
    seen = 2.0 * np.pi * radius / (speed * motion.step) > _SAMPLES
    number = (angle / (2.0 * np.pi * _REVOLUTIONS)).astype(int)
    ends = np.flatnonzero(np.diff(number)) + 1
    amplitudes = []
    for begin, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        if not seen[begin:end].all():
            continue
        at = angle[begin:end]
        line = np.vander(np.linspace(-1.0, 1.0, at.size), 4)
        columns = np.column_stack([line, np.cos(at), np.sin(at)])
        fit = np.linalg.lstsq(columns, speed[begin:end], rcond=None)[0]
        amplitudes.append(float(np.hypot(fit[-1], fit[-2])) / float(np.mean(speed[begin:end])))
    return float(np.median(amplitudes)) if len(amplitudes) >= _STRETCHES else 0.0
