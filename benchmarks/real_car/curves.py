"""ABS stops in curves, with messages of all three axes of an IMU: peaks of the friction curve of every wheel.

Cars: random ones of which the estimator knows the nominal one, and a measured one whose slips barely pass the peak. In
both no two tyres are the same. What has no one curve, or never passes its peak, may have no valid number.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from friction_msgs.msg import FrictionCurve
from numpy.typing import NDArray

from benchmarks.cycled_stops import FAMILIES, VEHICLE, Case, differing, drive, make_car, well_known
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling
from corner_sim.car.tyres import TYRES
from friction_curve_id.parameters import SHIPPED
from friction_curve_id.ros.car_processor import CarProcessor
from friction_parameters.parameter import changed
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SOON: Final = 0.6
"""Time after the first passing of the peak at which estimates are judged [s]."""
FOLLOWED: Final = 1.5
"""Time after that to which a stop is followed [s]."""
COVERAGE: Final = 90.0
"""Least share of the valid messages whose 95 % intervals hold the truth [%]."""
VALID: Final = 80.0
"""Least share of the stops that are valid SOON after the first passing [%]."""
MEDIAN: Final = {"lambda_max": 10.0, "mu_max": 3.0}
"""Largest medians of the errors [%]."""
_INTERVAL: Final = 1.96
_CURVES: Final = (("dry", 0.3), ("dry", 0.6), ("wet", 0.5), ("snow", 0.12))


@dataclass(frozen=True)
class CurveCase(Case):
    """A kind of stop, and how it is judged."""

    asked: bool = False
    """Numbers are asked for; else only what is valid has to be right."""
    silent: bool = False
    """No number may be valid."""


def _cases() -> Iterator[CurveCase]:
    for road, lateral in (*((road, 0.0) for road in TYRES["burckhardt"]), *_CURVES):
        for family in TYRES:
            name = f"random cars, {family} {road} {lateral} g"
            yield CurveCase(name, road, family, lateral, random=True, asked=lateral > 0.0)
    for road, lateral in _CURVES:
        yield CurveCase(f"shallow, {road} {lateral} g", road, lateral=lateral, asked=True)
    for road in ("dry", "snow"):
        yield CurveCase(f"shallow, {road} straight", road)
    for family in ("pacejka", "brush"):
        yield CurveCase(f"shallow, {family} wet 0.3 g", "wet", family, 0.3)
    yield CurveCase("dry 0.8 g", "dry", lateral=0.8)
    for road, lateral in _CURVES:
        yield CurveCase(f"{road} {lateral} g, yaw not measured", road, lateral=lateral, random=True, across=False)
    for road, right in (("dry", "snow"), ("dry", "wet"), ("wet", "snow")):
        yield CurveCase(f"split {road} | {right}", road, right=right, silent=True)
    for held in (0.2, 0.4, 0.6):
        yield CurveCase(f"held {held} g", "dry", random=True, held=held, silent=True)
    for held, lateral in ((0.3, 0.3), (0.5, 0.5)):
        yield CurveCase(
            f"held {held} g, curve {lateral} g", "dry", lateral=lateral, random=True, held=held, silent=True
        )


CASES: Final = {case.name: case for case in _cases()}


@dataclass(frozen=True)
class CurveStop:
    """What came of a stop; arrays of shape (samples, 4) from the first passing on, or from the begin of braking."""

    time: Array
    """Since then [s], (samples,)."""
    valid: Flags
    known: Flags
    """mu_max is a number."""
    lambda_error: Array
    """Relative."""
    mu_error: Array
    lambda_deviations: Array
    """Errors over stated standard deviations."""
    mu_deviations: Array


def make_curve_stop(job: tuple[str, int]) -> CurveStop:
    """Drive a case, by name, with a seed, and compare what was told with the truth.

    What a driver holds is judged until a wheel passes its peak: the inner one may, in a curve.
    """
    name, seed = job
    case = CASES[name]
    parameters, cycling = _car(case, seed)
    vehicle = load_vehicle(VEHICLE)
    vehicle = vehicle if case.random else well_known(vehicle)
    graph = ProcessorGraph([CarProcessor(vehicle, changed(SHIPPED["friction_curve_id"].parameters, {"method": "car"}))])
    wheels = {wheel: k for k, wheel in enumerate(vehicle.wheel_names)}
    rows: dict[int, Array] = {}
    truth = []
    passed_at = np.inf
    for at in drive(case, parameters, cycling, seed):
        truth.append((at.stamp, at.time, at.lambda_max, at.mu_max))
        if at.time > cycling.start and max(s / top for s, top in zip(at.slip, at.lambda_max, strict=True)) > 1.0:
            passed_at = min(passed_at, at.time)
        for topic, message in at.messages:
            for _, answer in graph.feed(topic, message):
                if isinstance(answer, FrictionCurve):
                    stamp = to_nanoseconds(answer.header.stamp)
                    rows.setdefault(stamp, np.full((4, 5), np.nan))[wheels[answer.wheel]] = (
                        answer.lambda_max,
                        answer.lambda_max_stddev,
                        answer.mu_max,
                        answer.mu_max_stddev,
                        float(answer.validity.valid),
                    )
        if at.time > passed_at + (0.0 if case.held else FOLLOWED):
            break
    first = cycling.start if case.held or np.isinf(passed_at) else passed_at
    judged = [
        (time, rows.get(stamp, np.full((4, 5), np.nan)), lam, mu) for stamp, time, lam, mu in truth if time >= first
    ]
    time = np.array([each[0] for each in judged]) - first
    said = np.array([each[1] for each in judged])
    lambda_max, mu_max = np.array([each[2] for each in judged]), np.array([each[3] for each in judged])
    return CurveStop(
        time,
        said[:, :, 4] == 1.0,
        np.isfinite(said[:, :, 2]),
        said[:, :, 0] / lambda_max - 1.0,
        said[:, :, 2] / mu_max - 1.0,
        (said[:, :, 0] - lambda_max) / said[:, :, 1],
        (said[:, :, 2] - mu_max) / said[:, :, 3],
    )


def _car(case: CurveCase, seed: int) -> tuple[CarParameters, Cycling]:
    """Random cars also differ by their tyres, roll stiffness, yaw inertia and friction across."""
    parameters, cycling = make_car(case, seed)
    rng = np.random.default_rng([seed, 6])
    if case.random:
        first, second, third, fourth = (differing(FAMILIES[case.family][case.road], rng) for _ in range(4))
        parameters = replace(parameters, tyres=(first, second, third, fourth))
    if case.random or case.lateral:
        parameters = replace(
            parameters,
            front_roll_stiffness=float(rng.uniform(0.5, 0.62)),
            gyration=float(rng.uniform(0.85, 1.05)),
            across=float(rng.uniform(0.85, 1.0)),
        )
    return parameters, cycling


def curve_rows(case: CurveCase, stops: Sequence[CurveStop]) -> list[Row]:
    """Rows of a case."""
    start: Row = {"case": case.name, "road": case.road, "stops": len(stops)}
    rows: list[Row] = []

    def add(quantity: str, judged: Row, **more: float) -> None:
        rows.append(start | {"quantity": quantity} | judged | more)

    if case.silent:
        share = 100.0 * float(np.mean([stop.known.any() for stop in stops]))
        add("mu_max valid [% of stops]", at_most(share, 0.0))
        return rows
    at = [min(int(np.searchsorted(stop.time, SOON)), len(stop.time) - 1) for stop in stops]
    for name, valid, error, deviations in (
        ("lambda_max", [s.valid for s in stops], [s.lambda_error for s in stops], [s.lambda_deviations for s in stops]),
        ("mu_max", [s.known for s in stops], [s.mu_error for s in stops], [s.mu_deviations for s in stops]),
    ):
        z = np.concatenate([each[told] for each, told in zip(deviations, valid, strict=True)])
        inside = 100.0 * float(np.mean(np.abs(z) <= _INTERVAL)) if z.size else 100.0
        rms = float(np.sqrt(np.mean(z**2))) if z.size else np.nan
        add(f"coverage of {name}, all valid messages [%]", at_least(inside, COVERAGE), z=rms, messages=float(z.size))
        errors = np.concatenate([each[k, told[k]] for each, told, k in zip(error, valid, at, strict=True)])
        median = 100.0 * float(np.median(np.abs(errors))) if errors.size else np.nan
        judged = at_most(median, MEDIAN[name]) if case.asked and errors.size else not_judged(median)
        bias = 100.0 * float(errors.mean()) if errors.size else np.nan
        add(f"median |error| of {name} after {SOON} s [%]", judged, bias_pct=bias)
        soon = [told[: k + 1].any() for told, k in zip(valid, at, strict=True)]
        within = 100.0 * float(np.mean(soon))
        add(f"{name} valid within {SOON} s [%]", at_least(within, VALID) if case.asked else not_judged(within))
    return rows
