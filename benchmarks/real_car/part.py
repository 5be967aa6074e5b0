"""Friction curves of cars with uncertain parameters, on the independent plant corner_sim.car, with limits.

Study `perturbations`: each perturbation alone on a car with the values of the vehicle file.
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from benchmarks.engine import results_of
from benchmarks.real_car.bound import Bound, bound, bound_rows
from benchmarks.real_car.curves import CASES, curve_rows, make_curve_stop
from benchmarks.real_car.driving import (
    DRIVE,
    Across,
    Drive,
    DriveResult,
    SlopeDrive,
    curves_of_drive,
    drive_rows,
    record_drive,
    signs_of_drive,
    slope_drive_rows,
)
from benchmarks.real_car.known import Known, cost_rows, known_rows, make_known, timed
from benchmarks.real_car.road_change import (
    CHANGES,
    SPLITS,
    Rise,
    TwoRoads,
    make_rise,
    make_two_roads,
    rise_rows,
    two_roads_rows,
)
from benchmarks.real_car.stops import Stop, make_stop, stop_rows
from benchmarks.real_car.traction import STARTS, make_start, start_rows
from benchmarks.runner import Row
from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import Cycling
from corner_sim.car.random_car import random_car
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Scaled
from friction_parameters.command_line import count, positive
from vehicle_models.surfaces import TABLE_8_1

ROADS = tuple(TYRES["burckhardt"])
NOMINAL_CAR = CarParameters(
    relaxation_length=(0.3,) * 4,
    damper_share=0.5,
    pitch_gain=0.0026,
    sensors=SensorParameters(encoder_teeth=48, acceleration_delay=0.005),
)
"""The car without any perturbation."""


def _gains(factor: float) -> Mapping[str, Any]:
    gains = CarParameters().brake_gain
    return {"brake_gain": tuple(factor * gain for gain in gains)}


PERTURBATIONS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "none": {},
        "load transfer +10 %": {"height": 1.1 * CarParameters().height},
        "relaxation 0.05 m": {"relaxation_length": (0.05,) * 4},
        "relaxation 0.6 m": {"relaxation_length": (0.6,) * 4},
        "pressure 10 ms late": {"pressure_delay": 0.01},
        "pressure 20 ms late": {"pressure_delay": 0.02},
        "brake gain -10 %": _gains(0.9),
        "pads fading 20 %": {"fading": 0.2},
        "slope 5 %": {"slope": 0.05},
        "engine drag 100 N m": {"engine_drag": 100.0},
        "wheel stamps 10 ms late": {"wheel_delay": 0.01},
        "48 teeth at 100 Hz": {"encoder_teeth": 48, "sample_rate": 100},
        "Pacejka": {"family": "pacejka"},
        "brush tyres": {"family": "brush"},
        "tyres with load sensitivity 10 %": {"load_sensitivity": 0.1},
        "radius 2 % less at twice the load": {"radius_loss": 0.02},
        "other tyres at the rear": {"rear": {"friction_factor": 1.06, "slip_factor": 1.1}},
        "load varying 5 % RMS": {"load_variation": 0.05},
        "first rise of 3 s": {"ramp": 3.0},
        "50 Hz": {"sample_rate": 50},
        "1000 Hz": {"sample_rate": 1000},
    }
)
"""Changes to the car, by the name of the perturbation."""


def perturbed_car(perturbation: str, road: str) -> tuple[CarParameters, Cycling]:
    """Make the car of a perturbation on a road, and the way it is braked."""
    changes = dict(PERTURBATIONS[perturbation])
    cycling = Cycling(ramp=changes.pop("ramp", Cycling.ramp))
    tyre = {**TYRES, "brush": BRUSH_TYRES}[changes.pop("family", "burckhardt")][road]
    rear = Scaled(tyre, **changes.pop("rear")) if "rear" in changes else tyre
    of_sensors = {name: changes.pop(name) for name in list(changes) if hasattr(SensorParameters, name)}
    sensors = replace(NOMINAL_CAR.sensors, **of_sensors)
    return replace(NOMINAL_CAR, tyres=(tyre, tyre, rear, rear), sensors=sensors, **changes), cycling


_FIRST_SEED = 40_000
"""Far from the seeds of the tuning."""
_STUDIES = ("perturbations", "random", "before_peak", "road_change", "driving", "known", "cost", "curves", "traction")
_KNOWN_RUNS = 20
"""Runs of a known corner in one task of a process."""
_TIMED = 2
"""Stops a road of the cost."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=50, help="seeds a perturbation and road; random cars a road")
    parser.add_argument("--hours", type=positive, default=0.2, help="hours of ordinary driving")
    parser.add_argument("--first-drive", type=count, default=1, help="number of the first drive: long ones in parts")
    parser.add_argument("--studies", nargs="+", choices=_STUDIES, default=list(_STUDIES), help="what to study")
    parser.add_argument(
        "--perturbations", nargs="+", choices=PERTURBATIONS, default=list(PERTURBATIONS), help="for 'perturbations'"
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), help="for 'curves', by name")


def run(options: argparse.Namespace) -> list[Row]:
    """Make the studies and return their rows."""
    studies = {
        "perturbations": _perturbations,
        "random": _random,
        "before_peak": _before_peak,
        "road_change": _road_change,
        "driving": _driving,
        "known": _known,
        "cost": _cost,
        "curves": _curves,
        "traction": _traction,
    }
    return [row for name in options.studies for row in studies[name](options)]


def _perturbations(options: argparse.Namespace) -> list[Row]:
    cases = [(perturbation, road) for perturbation in options.perturbations for road in ROADS]
    jobs = [
        Stop(*perturbed_car(perturbation, road), _FIRST_SEED + seed)
        for perturbation, road in cases
        for seed in range(options.seeds)
    ]
    results = results_of(make_stop, jobs, "one perturbation")
    rows: list[Row] = []
    for number, (perturbation, road) in enumerate(cases):
        of_case = results[number * options.seeds : (number + 1) * options.seeds]
        rows += stop_rows(perturbation, road, of_case, judge_errors=False)
    return rows


def _random(options: argparse.Namespace) -> list[Row]:
    jobs = []
    for road in ROADS:
        for seed in range(options.seeds):
            number = _FIRST_SEED + seed
            car = random_car(number, road, _family(seed))
            jobs.append(Stop(car.parameters, car.cycling, number))
    results = results_of(make_stop, jobs, "random cars")
    cars = [Bound(_FIRST_SEED + seed, road, _family(seed)) for road in ROADS for seed in range(options.seeds)]
    bounds = results_of(bound, cars, "bound with all perturbations")
    rows = stop_rows("random cars", "all", results, judge_errors=True) + bound_rows("all", bounds)
    for number, road in enumerate(ROADS):
        of_road = slice(number * options.seeds, (number + 1) * options.seeds)
        rows += [_informing(row) for row in stop_rows("random cars", road, results[of_road], judge_errors=True)]
        rows += bound_rows(road, bounds[of_road])
    return rows


def _traction(options: argparse.Namespace) -> list[Row]:
    jobs = [(name, _FIRST_SEED + seed) for name in STARTS for seed in range(options.seeds)]
    results = results_of(make_start, jobs, "traction")
    rows: list[Row] = []
    for number, name in enumerate(STARTS):
        rows += start_rows(name, results[number * options.seeds : (number + 1) * options.seeds])
    return rows


def _before_peak(options: argparse.Namespace) -> list[Row]:
    rows: list[Row] = []
    for family in TYRES:
        jobs = [Rise(_FIRST_SEED + seed, road, family) for road in ROADS for seed in range(options.seeds)]
        results = results_of(make_rise, jobs, f"before the peak, {family}")
        rows += rise_rows(family, [each for result in results for each in result])
    return rows


def _road_change(options: argparse.Namespace) -> list[Row]:
    cases = [(roads, False) for roads in CHANGES] + [(roads, True) for roads in SPLITS]
    jobs = [
        TwoRoads(_FIRST_SEED + seed, roads, split, _family(seed))
        for roads, split in cases
        for seed in range(options.seeds)
    ]
    results = results_of(make_two_roads, jobs, "two roads")
    rows: list[Row] = []
    for number, (roads, split) in enumerate(cases):
        rows += two_roads_rows(roads, split, results[number * options.seeds : (number + 1) * options.seeds])
    return rows


def _driving(options: argparse.Namespace) -> list[Row]:
    jobs = drives(options.hours, options.first_drive)
    results = results_of(_one_drive, jobs, "ordinary driving")
    return drive_rows([curves for curves, _ in results]) + slope_drive_rows([signs for _, signs in results])


def drives(hours: float, first: int) -> list[Drive]:
    """Drives of `hours` together, from the one with the number `first` >= 1 on; cars and IMUs go by number."""
    seconds = round(3600.0 * hours, 3)
    return [
        Drive(
            _FIRST_SEED + k,
            ROADS[k // 2 % len(ROADS)],
            _family(k),
            Across(k % len(Across)),
            min(DRIVE, seconds - done * DRIVE),
        )
        for done, k in enumerate(range(first - 1, first - 1 + int(-(-seconds // DRIVE))))
    ]


def _one_drive(drive: Drive) -> tuple[DriveResult, SlopeDrive]:
    """Both estimates follow the same recording: the plant takes a third of a drive's time."""
    run = record_drive(drive)
    return curves_of_drive(run, drive), signs_of_drive(run, drive)


def _known(options: argparse.Namespace) -> list[Row]:
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
    jobs = [
        Known(road, tuple(seeds[first : first + _KNOWN_RUNS]))
        for road in TABLE_8_1
        for first in range(0, options.seeds, _KNOWN_RUNS)
    ]
    found = results_of(make_known, jobs, "known exactly")
    return known_rows([(job.road, answers) for job, answers in zip(jobs, found, strict=True)])


def _cost(options: argparse.Namespace) -> list[Row]:
    jobs = [Bound(_FIRST_SEED + seed, road, _family(seed)) for road in ROADS for seed in range(_TIMED)]
    return cost_rows([timed(job) for job in jobs])


def _curves(options: argparse.Namespace) -> list[Row]:
    jobs = [(name, _FIRST_SEED + seed) for name in options.cases for seed in range(options.seeds)]
    stops = results_of(make_curve_stop, jobs, "curves")
    rows: list[Row] = []
    for number, name in enumerate(options.cases):
        rows += curve_rows(CASES[name], stops[number * options.seeds : (number + 1) * options.seeds])
    return rows


def _family(number: int) -> str:
    """Every second car has tyres of the other family."""
    return tuple(TYRES)[number % len(TYRES)]


def _informing(row: Row) -> Row:
    """The limits hold for all roads together."""
    return row | {"limit": None, "passed": None}
