"""Parameters that several nodes have with the same meaning; only their values differ."""

from typing import Any

from friction_parameters.parameter import parameter


def max_gap(default: float) -> Any:
    """Longest time between two samples of one input that is bridged [s]."""
    return parameter(
        default,
        "longest time between two samples of an input; a longer gap is not interpolated, and the estimate starts again",
        unit="s",
        minimum=0.001,
        maximum=2.0,
    )


def minimum_speed(default: float) -> Any:
    """Vehicle speed below which nothing is estimated [m/s]."""
    return parameter(default, "no estimate below this vehicle speed", unit="m/s", minimum=0.1, maximum=50.0)


def deadline(default: float = 0.05) -> Any:
    """Message time for which the primary input waits for the others [s]."""
    return parameter(default, "message time a sample waits for the other inputs", unit="s", minimum=0.001, maximum=1.0)
