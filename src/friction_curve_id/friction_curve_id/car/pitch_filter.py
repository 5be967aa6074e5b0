"""The filter of pitch.py, discretised by the trapezoidal rule (Tustin).

A plain loop, which is compiled: importing scipy.signal takes longer than all else that a node or a command does at
start.
"""

from math import exp


def filtered(
    force: list[float],
    interval: float,
    log_frequency: float,
    damping: float,
    share: float,
    inputs: tuple[float, float],
    outputs: tuple[float, float],
) -> list[float]:
    """Return the load transfer q, or the pitch p for share 0, in units of the specific force [m/s^2].

    Args:
        force: specific force f [m/s^2], n samples.
        interval: time between samples [s].
        log_frequency: ln w, w in rad/s.
        damping: zeta.
        share: d.
        inputs: forces before the first, newest first.
        outputs: results before the first, newest first.
    """
    x = 0.5 * exp(log_frequency) * interval
    zeta = min(max(damping, 0.05), 2.0)
    square, first = x * x, 2.0 * zeta * x
    scale = 1.0 / (1.0 + first + square)
    b0, b1, b2 = (square + share * first) * scale, 2.0 * square * scale, (square - share * first) * scale
    a1, a2 = 2.0 * (square - 1.0) * scale, (1.0 - first + square) * scale
    later = b1 * inputs[0] + b2 * inputs[1] - a1 * outputs[0] - a2 * outputs[1]
    latest = b2 * inputs[0] - a2 * outputs[0]
    results: list[float] = []
    for taken in force:
        given = later + b0 * taken
        later = latest + b1 * taken - a1 * given
        latest = b2 * taken - a2 * given
        results.append(given)
    return results
