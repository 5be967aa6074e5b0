"""The pitch is what scipy's recursion gives, and the node starts without scipy.signal."""

import subprocess
import sys
from math import exp, log

import numpy as np
from scipy import signal

from friction_curve_id.car.pitch import PitchState, pitch_of_body
from friction_curve_id.car.unknowns import Unknown

_INTERVAL = 0.005
_FREQUENCY, _DAMPING, _SHARE = 8.0, 0.25, 0.6
"""[rad/s], [-], [-]"""


def test_pitch_and_load_are_those_of_scipy() -> None:
    random = np.random.default_rng(1)
    force = random.normal(-5.0, 2.0, 150)
    unknowns = np.zeros(len(Unknown))
    unknowns[Unknown.LOG_PITCH_FREQUENCY] = log(_FREQUENCY)
    unknowns[Unknown.PITCH_DAMPING], unknowns[Unknown.DAMPER_SHARE] = _DAMPING, _SHARE
    state = PitchState(force=(-3.0, -2.5), pitch=(-1.0, -0.9), load=(-1.2, -1.0))
    found = pitch_of_body(force, _INTERVAL, unknowns, state)
    np.testing.assert_allclose(found.pitch, _by_scipy(force, 0.0, state.force, state.pitch), rtol=1e-12)
    np.testing.assert_allclose(found.load, _by_scipy(force, _SHARE, state.force, state.load), rtol=1e-12)


def test_the_node_starts_without_scipy_signal() -> None:
    code = "import sys, friction_curve_id.ros.node; sys.exit('scipy.signal' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


def _by_scipy(force: np.ndarray, share: float, inputs: tuple[float, float], outputs: tuple[float, float]) -> np.ndarray:
    x = 0.5 * exp(log(_FREQUENCY)) * _INTERVAL
    square, first = x * x, 2.0 * _DAMPING * x
    scale = 1.0 / (1.0 + first + square)
    b = [(square + share * first) * scale, 2.0 * square * scale, (square - share * first) * scale]
    a = [1.0, 2.0 * (square - 1.0) * scale, (1.0 - first + square) * scale]
    later = b[1] * inputs[0] + b[2] * inputs[1] - a[1] * outputs[0] - a[2] * outputs[1]
    found, _ = signal.lfilter(b, a, force, zi=[later, b[2] * inputs[0] - a[2] * outputs[0]])
    return np.asarray(found)
