"""The filter gives what scipy's recursion gives, to the last bit, and the node starts without scipy."""

import subprocess
import sys

import numpy as np
import pytest
from scipy import signal

from smart_tyre_forces.fir import filtered

RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("taps", [signal.windows.hann(7)[1:-1], RANDOM.normal(size=61), np.array([2.0])])
@pytest.mark.parametrize("shape", [(61,), (400,), (5, 700)])
def test_results_are_those_of_scipy_to_the_last_bit(taps: np.ndarray, shape: tuple[int, ...]) -> None:
    values = RANDOM.normal(size=shape) * 10.0 ** RANDOM.uniform(-3.0, 3.0, size=shape)
    # A two-term denominator keeps scipy on its sample-by-sample recursion.
    expected = signal.lfilter(taps, (1.0, 0.0), values)[..., len(taps) - 1 :]
    np.testing.assert_array_equal(filtered(taps, values), expected)


def test_blocks_give_what_the_whole_gives() -> None:
    taps, values = RANDOM.normal(size=7), RANDOM.normal(size=300)
    parts = [filtered(taps, values[max(begin - 6, 0) : begin + 50]) for begin in range(0, 300, 50)]
    np.testing.assert_array_equal(np.concatenate(parts), filtered(taps, values))


def test_the_node_starts_without_scipy() -> None:
    code = "import sys, smart_tyre_forces.ros.node; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0
