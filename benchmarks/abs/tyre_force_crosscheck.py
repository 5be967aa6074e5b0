"""Tyre force cross-check outside the loop: mu = Fx / Fz of `tyre_force` (8.14), (8.16), and its delay.

The car of the demo: 8 m/s, on which the tyres find their zero, up to 22 m/s, and a panic stop under a law of
abs_supervisor, which does not hear of them. A force is that of one contact patch, one in a turn of the wheel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf, isnan, nan
from typing import Any

import numpy as np
from friction_msgs.msg import FrictionCurve, TyreForce
from numpy.typing import NDArray

from benchmarks.abs.car import SHIPPED_CAR, CarSetup
from benchmarks.abs.panic_stop import LONGEST
from benchmarks.closed_loop import loop_parameters, take_sample
from benchmarks.runner import Row
from corner_sim.car.tyres import TYRES
from corner_sim.car_plant import CarModelParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, make_processors
from friction_bringup.demo_drive import plant_of_demo
from friction_bringup.graph import PLANT, plant_calibration
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph, silent
from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

SMART_TYRES = "smart_tyres"
"""Name of the car with smart tyres."""
_START = 10_000 * NANOSECONDS
_NEAR = 0.9
"""Of mu_max: from there on a tyre that says so says that the peak is near."""


@dataclass(frozen=True)
class Opinion:
    """One message of a tyre."""

    came: int
    """When [ns]."""
    stamp: int
    """Of what it says [ns]."""
    mu: float
    """[-] positive in braking; NaN where it says nothing."""
    stddev: float
    """As stated [-]."""


@dataclass
class Heard:
    """Of one wheel in one stop, from the onset on."""

    opinions: list[Opinion] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    """[ns] of the true friction."""
    friction: list[float] = field(default_factory=list)
    """True [-], positive in braking, at each of them."""
    curve: int | None = None
    """When the first valid curve came [ns]."""

    def errors(self) -> tuple[Array, Array]:
        """Return the errors of what was said and their stated standard deviations [-], both of shape (k,)."""
        said = [each for each in self.opinions if not isnan(each.mu)]
        true = np.interp([each.stamp for each in said], self.stamps, self.friction)
        return np.array([each.mu for each in said]) - true, np.array([each.stddev for each in said])

    def lag(self, mu: float) -> float:
        """Return how long after the tyre had a friction of `mu` it says so [s]: inf for never, NaN if it never had."""
        reached = [stamp for stamp, true in zip(self.stamps, self.friction, strict=True) if true >= mu]
        if not reached:
            return nan
        reported = [each.came for each in self.opinions if each.mu >= mu and each.stamp >= reached[0]]
        return (reported[0] - reached[0]) / NANOSECONDS if reported else inf


def heard(road: str, seed: int, law: str) -> tuple[Mapping[str, Heard], int]:
    """Brake once; return what was heard of each wheel, and the onset [ns]."""
    setup = CarSetup(road)
    drive: Mapping[str, Any] = plant_of_demo(road, SHIPPED_CAR)[PLANT]
    onset = drive["demand_start"]
    plant = replace(
        setup.parameters,
        initial_speed=drive["initial_speed"],
        demand_start=onset,
        car=CarModelParameters(
            drive_times=tuple(drive["car.drive_times"]), drive_speeds=tuple(drive["car.drive_speeds"])
        ),
        tyre_signals=True,
        seed=seed,
    )
    simulation = Simulation(plant, setup.vehicle, _START)
    parameters = loop_parameters(ESTIMATORS, law)
    parameters[SMART_TYRE] = replace(parameters[SMART_TYRE], calibration_file=str(plant_calibration()))
    graph = ProcessorGraph(make_processors(parameters, setup.nominal, silent))
    begin = _START + round(onset * NANOSECONDS)
    found = {wheel: Heard() for wheel in setup.nominal.wheel_names}
    while simulation.end is None and simulation.time < onset + LONGEST:
        braking = simulation.stamp >= begin
        for topic, message in take_sample(simulation, graph):
            if braking and not topic.startswith("truth/"):
                _note(found, simulation.stamp, begin, message)
            elif braking and topic.endswith("/tyre_force"):
                found[message.wheel].stamps.append(simulation.stamp)
                found[message.wheel].friction.append(-message.fx / message.fz)
        simulation.advance()
    return found, begin


def _note(found: Mapping[str, Heard], now: int, begin: int, message: object) -> None:
    if isinstance(message, TyreForce) and to_nanoseconds(message.header.stamp) >= begin:
        mu = -message.fx / message.fz if message.validity.valid else nan
        stddev = hypot(message.fx_stddev, mu * message.fz_stddev) / message.fz if message.validity.valid else nan
        opinion = Opinion(now, to_nanoseconds(message.header.stamp), mu, stddev)
        found[message.wheel].opinions.append(opinion)
    elif isinstance(message, FrictionCurve) and message.validity.valid:
        wheel = found[message.wheel]
        wheel.curve = wheel.curve or now


def opinion_row(law: str, seeds: range, road: str) -> Row:
    """Return the row of a road, for information."""
    stops = [heard(road, seed, law) for seed in seeds]
    wheels = [wheel for found, _ in stops for wheel in found.values()]
    mu_max = TYRES["burckhardt"][road].peak[1]
    errors, stddevs = (np.concatenate(each) for each in zip(*(wheel.errors() for wheel in wheels), strict=True))
    every = [each for wheel in wheels for each in wheel.opinions]
    ages = [(each.came - each.stamp) / NANOSECONDS for each in every]
    curves = [(wheel.curve - begin) / NANOSECONDS for found, begin in stops for wheel in found.values() if wheel.curve]
    return {
        "car": SMART_TYRES,
        "surface": road,
        "case": "second opinion",
        "law": law,
        "seeds": len(seeds),
        "value": float(np.sqrt(np.mean(errors**2))),
        "limit": None,
        "passed": None,
        "mu_max": mu_max,
        "bias": float(np.mean(errors)),
        "reported_stddev": float(np.median(stddevs)),
        "says_something": len(errors) / len(every),
        "largest_said": float(max(each.mu for each in every if not isnan(each.mu))),
        "age_s": float(np.median(ages)),
        "largest_age_s": max(ages),
        **_lags([wheel.lag(_NEAR * mu_max) for wheel in wheels]),
        "curve_valid_s": float(np.median(curves)) if curves else None,
    }


def _lags(found: Sequence[float]) -> Row:
    """Return after how long the wheels say that the peak is near, as far as they get there and ever say so."""
    there = [each for each in found if not isnan(each)]
    said = [each for each in there if each < inf]
    return {
        "wheels_near_peak": len(there),
        "of_these_say_so": len(said),
        "lag_s": float(np.median(said)) if said else None,
        "largest_lag_s": max(said, default=None),
    }
