"""Stops of one corner with the graph in the loop: no speed sensor, an accelerometer with offset and noise."""

from dataclasses import replace
from functools import partial

from benchmarks.closed_loop.braked_corners import BrakedCorners, InertialSensing
from benchmarks.closed_loop.controller import processors, shipped
from benchmarks.closed_loop.panic_stop import PanicStops, brake_to_rest
from benchmarks.closed_loop.threshold_abs import THRESHOLDS, ThresholdAbs
from benchmarks.closed_loop.trouble import Trouble
from benchmarks.protocol import ACCELERATION_STDDEV, DT
from friction_runtime.processor import Processor
from vehicle_models.vehicle import Vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.ros.processor import CarProcessor

OFFSET = 0.15
"""Of the accelerometer [m/s^2]."""
ROLLING = round(3.0 / DT)
"""Samples of free rolling before the brake, in which wheel_slip learns the offset of the accelerometer."""


def law_stops(surface: str, seeds: range, law: str, trouble: Trouble) -> PanicStops:
    """Brake once for each seed, side by side.

    Args:
        surface: its name.
        seeds: of the sensor noise and the road's roughness.
        law: of abs_supervisor, or THRESHOLDS.
        trouble: what the graph is not told of.
    """
    sensing = InertialSensing(speed_sensor=False, offset=OFFSET, stddev=ACCELERATION_STDDEV)
    braked = BrakedCorners(surface, seeds, partial(_processors, law), sensing, trouble)
    braked.roll(ROLLING)
    return brake_to_rest(braked.plant, braked.brake)


def _processors(law: str, alone: Vehicle) -> list[Processor]:
    if law == THRESHOLDS:
        (wheel,) = alone.wheels
        return [CarProcessor(alone, SHIPPED_SLIP["wheel_slip"].parameters), ThresholdAbs(wheel.name, wheel.radius)]
    slope, supervisor = shipped()
    return processors(alone, (slope, replace(supervisor, real_time=False, law=law)))
