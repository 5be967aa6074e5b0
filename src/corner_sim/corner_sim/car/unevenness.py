"""Unevenness of the road: the load of each wheel varies around its mean in a band of 1 to 14 Hz."""

import numpy as np

BAND = (1.0, 14.0)
"""Frequencies [Hz]; the spectrum between them is flat."""
PERIOD = 32.0
"""Time after which the road repeats [s]."""


def load_variation(rms: float, seed: int, dt: float) -> list[tuple[float, ...]]:
    """Draw the relative load of four wheels, independent of each other.

    Args:
        rms: of the relative load of each wheel [-], >= 0; exact over the period.
        seed: same seed, same road.
        dt: time step [s].

    Returns:
        One period of relative loads around 1, each of 4.
    """
    n = round(PERIOD / dt)
    if rms == 0.0:
        return [(1.0,) * 4] * n
    frequency = np.fft.rfftfreq(n, dt)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    # a stream of its own: the noise of the sensors has the same seed
    phase = np.random.default_rng([seed, 1]).uniform(0.0, 2.0 * np.pi, (inside.sum(), 4))
    spectrum = np.zeros((frequency.size, 4), dtype=complex)
    spectrum[inside] = np.exp(1j * phase)
    variation = np.fft.irfft(spectrum, n, axis=0)
    variation *= rms / np.sqrt((variation**2).mean(axis=0))
    return [tuple(row) for row in (1.0 + variation).tolist()]
