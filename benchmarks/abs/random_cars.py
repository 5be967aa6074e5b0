"""Emergency stops of unknown cars: mass, brakes, radii, tyres, hydraulics, load and slope are drawn at once."""

import numpy as np

from benchmarks.abs.car import CarSetup, car_stop
from benchmarks.abs.panic_stop import LOCK_TIME, Perturbation
from benchmarks.runner import Row

RANDOM = "random"
"""Name of these cars."""
FAMILIES = ("burckhardt", "pacejka", "steep")
"""Of their tyres."""
_LONGEST_LOCK = 0.5
"""[s] at most."""


def random_setup(seed: int, road: str, family: str) -> CarSetup:
    """Draw a car around the one of the vehicle file: the same for each road and family.

    Uniform: brake gain +-10 %, mass +-15 %, radius +-1 %, hydraulics 0-15 ms later and +-20 % faster, load varying
    0-5 % RMS, relaxation 0.05-0.4 m, slope +-4 %.
    """
    rng = np.random.default_rng([seed, 43])
    return CarSetup(
        road,
        Perturbation(
            name=RANDOM,
            gain=float(rng.uniform(0.9, 1.1)),
            mass=float(rng.uniform(0.85, 1.15)),
            radius=float(rng.uniform(0.99, 1.01)),
            delay=float(rng.uniform(0.0, 0.015)),
            apply_rate=float(rng.uniform(0.8, 1.2)),
            load_variation=float(rng.uniform(0.0, 0.05)),
            relaxation_length=float(rng.uniform(0.05, 0.4)),
            hill=float(rng.uniform(-0.04, 0.04)),
        ),
        tyre=family,
    )


def random_row(law: str, seeds: range, road: str, family: str) -> Row:
    """Return the row of a road and a family of tyres; each seed is a car.

    Beside it stands, of the slips that `friction_curve` says are valid, how many are within their 95 % interval.
    """
    cars = [car_stop(random_setup(seed, road, family), seed, law) for seed in seeds]
    found = [car.stops for car in cars]
    lock = max(float(stop.longest_lock[0]) for stop in found)
    error, stddev = (np.concatenate([getattr(car, name) for car in cars]) for name in ("slip_error", "slip_stddev"))
    slips: Row = {}
    if error.size:
        slips["slip_covered_pct"] = 100.0 * float(np.mean(np.abs(error) < 1.96 * stddev))
        slips["slip_rms_error"] = float(np.sqrt(np.mean(error**2)))
    return {
        "car": RANDOM,
        "surface": road,
        "case": family,
        "law": law,
        "seeds": len(seeds),
        "value": lock,
        "limit": _LONGEST_LOCK,
        "passed": lock <= _LONGEST_LOCK,
        "failures": "" if lock <= _LONGEST_LOCK else f"lock {lock:.3f} s",
        "utilisation": float(np.mean([stop.utilisation[0] for stop in found])),
        "worst": float(min(stop.utilisation[0] for stop in found)),
        "longest_lock_s": lock,
        "runs_with_lock": sum(bool(stop.longest_lock[0] >= LOCK_TIME) for stop in found),
        **slips,
    }
