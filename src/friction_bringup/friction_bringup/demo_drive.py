"""Scenario of the demo's plant: car, road and the driver's braking."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from corner_sim.car_plant import CAR, SAME, in_order
from friction_bags.offline.estimators import SMART_TYRE
from friction_bringup.graph import PLANT, ParameterValue, plant_calibration
from friction_parameters.parameter import ParameterError
from vehicle_models import burckhardt
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.surfaces import SURFACES, TABLE_8_1, surface
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

CARS = {"car": "compact_car", "corner": "chapter_corner"}
"""Vehicle files of the cars to choose from by one word."""
CALIBRATION = "calibration_file"
"""Parameter of smart_tyre_forces that a user's file decides, where it does; else the tyres are those of the plant."""
WAITED_FOR = "wait_for_subscribers"
"""Parameter of the plant that a user's file decides, where it does; else all that take part are waited for."""
_ROLLING_SPEED = 8.0
"""Speed [m/s] at which the smart tyres find their zero."""
_ROLLING_TIME = 5.0
"""Time at it [s]."""
_BRAKING_SPEED = 22.0
"""Speed from which the car brakes [m/s]."""
_CRUISE = 1.5
"""Time [s] at that speed."""
_ACCELERATION = 2.8
"""Of the car where the road has the grip for it [m/s^2]."""
_SHARE_OF_GRIP = 0.5
"""Most that the driven axle takes of the grip it has at rest."""
_ON_THE_FIRST_ROAD = 15.0
"""Way [m] that the braking car has on the first of two roads."""


@dataclass(frozen=True)
class _Road:
    """Surfaces under the wheels."""

    behind_one_another: tuple[str, ...]
    right: str = SAME


_ROADS = {
    **{name: _Road((name,)) for name in TABLE_8_1},
    "split": _Road(("dry",), right="snow"),
    "dry snow": _Road(("dry", "snow")),
}
ROADS = tuple(_ROADS)
"""Named roads of the demo: one surface all the way, two sides, or one behind the other."""
ROAD_TEXT = f"road of the plant: {', '.join(ROADS)}, or theta of Burckhardt's curve as 1.28,24,0.52"


def plant_of_demo(road: str, vehicle_file: str) -> Mapping[str, Mapping[str, ParameterValue]]:
    """Return what the demo decides of the plant and of the smart tyres, by node.

    A car with four wheels rolls at 8 m/s, drives up to 22 m/s with at most half of the grip of its driven axle, and
    brakes to standstill. Any other brakes from the speed in its parameter file, at once.

    Args:
        road: one of ROADS, or theta of a surface such as "1.28,24,0.52".
        vehicle_file: path or name of the vehicle file.

    Raises:
        ParameterError: there is no such road or vehicle file, or the road has two sides and the car has not.
    """
    vehicle, surfaces = load_vehicle(vehicle_file), _road(road)
    if not _has_four_wheels(vehicle):
        if surfaces != _Road((road,)):
            raise ParameterError(f"surface '{road}' needs a car with four wheels, which '{vehicle.name}' has not")
        return {PLANT: {"surfaces": [road]}}
    return {PLANT: _drive(surfaces, vehicle), SMART_TYRE: {CALIBRATION: str(plant_calibration())}}


def _road(name: str) -> _Road:
    if name in _ROADS:
        return _ROADS[name]
    try:
        if name not in SURFACES and surface(name).size:
            return _Road((name,))
    except ValueError as error:
        raise ParameterError(f"{error} ({ROAD_TEXT})") from None
    raise ParameterError(f"surface '{name}' is no road of the demo ({ROAD_TEXT})")


def _has_four_wheels(vehicle: Vehicle) -> bool:
    try:
        in_order(vehicle)
    except ValueError:
        return False
    return True


def _drive(road: _Road, vehicle: Vehicle) -> dict[str, ParameterValue]:
    sides = (road.behind_one_another[0], *(() if road.right == SAME else (road.right,)))
    grip = min(float(burckhardt.peak(surface(name))[1]) for name in sides)
    traction = _SHARE_OF_GRIP * grip * (1.0 - vehicle.front_load_share) * GRAVITY
    resistance = vehicle.rolling_resistance * GRAVITY
    resistance += 0.5 * AIR_DENSITY * vehicle.drag_area * _BRAKING_SPEED**2 / vehicle.mass
    acceleration = min(_ACCELERATION, traction - resistance)
    reached = _ROLLING_TIME + (_BRAKING_SPEED - _ROLLING_SPEED) / acceleration
    onset = reached + _CRUISE
    way = _ROLLING_SPEED * _ROLLING_TIME + _BRAKING_SPEED * _CRUISE
    way += 0.5 * (_BRAKING_SPEED + _ROLLING_SPEED) * (reached - _ROLLING_TIME) + _ON_THE_FIRST_ROAD
    return {
        "model": CAR,
        "initial_speed": _ROLLING_SPEED,
        "surfaces": list(road.behind_one_another),
        "surface_distances": [k * way for k in range(len(road.behind_one_another))],
        "car.right_surface": road.right,
        "car.drive_times": [0.0, _ROLLING_TIME, reached],
        "car.drive_speeds": [_ROLLING_SPEED, _ROLLING_SPEED, _BRAKING_SPEED],
        "demand_start": onset,
        "acceleration_variance": 0.0025,
        "vehicle_velocity": False,
        "tyre_signals": True,
    }
