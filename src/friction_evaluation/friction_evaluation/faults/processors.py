"""The shipped processors of the graph, and how a node watches them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from friction_bags.offline.estimators import make_processors, read_parameters
from friction_runtime.processor import Output, Processor, silent
from vehicle_models.vehicle import Vehicle

WATCH_PERIOD = 0.01
"""Time between two looks of a node at the age of its inputs [s]."""
LAWS = ("slope_sign",)
"""What may ask for a release: the sign of the slope, section 8.2.2."""
_NODES = ("wheel_slip", "friction_slope", "friction_curve_id", "abs_supervisor")


def shipped_processors(vehicle: Vehicle) -> list[Processor]:
    """Return the processors with their shipped parameters; the supervisor commands."""
    parameters = read_parameters(_NODES, [], silent)
    parameters["abs_supervisor"] = replace(parameters["abs_supervisor"], shadow=False)
    return make_processors(parameters, vehicle, silent)


def watch(processor: Processor, ages: Mapping[str, float], now: float) -> Sequence[Output]:
    """Let a processor act on silence; `ages` of its inputs and `now` by the steady clock [s]."""
    return processor.watch(ages, now)
