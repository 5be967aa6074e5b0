"""Grip: friction used, proven and left against the truth of a plant that shares no code with the estimator."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan

import numpy as np
from numpy.typing import NDArray

from benchmarks.engine import results_of
from benchmarks.grip.drives import GripDrive, drive
from benchmarks.runner import Row, at_least, at_most, not_judged
from friction_grip.friction_used import FrictionUsed, GripInUse
from friction_grip.parameters import FrictionGripParameters
from friction_grip.road_memory import RoadMemory
from friction_grip.road_prior import RoadPrior
from friction_parameters.command_line import count
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator

Array = NDArray[np.float64]
_PARTS = ("car", "front", "rear", "wheels")
_RMS = {"car": 0.015, "front": 0.02, "rear": 0.025}
_CALIBRATED = 0.05
"""Deviation of an accelerometer's bias that vehicle_doctor has found [m/s^2]."""
_CHANGED = 0.2
"""Time over which a force is meant [s]: within it after a change of road the proof is of both."""
_ODOMETRY = 0.05
"""Error of a distance by wheel speeds, relative: radii of 3 %, and wheels that slip."""
BELIEFS = {
    "prior as it is": FrictionGripParameters(),
    "prior all ice": FrictionGripParameters(prior=RoadPrior(0.0, 0.0, 0.0, 1.0)),
    "prior all dry": FrictionGripParameters(prior=RoadPrior(1.0, 0.0, 0.0, 0.0)),
    "change_distance 60 m": FrictionGripParameters(change_distance=60.0),
    "change_distance 1500 m": FrictionGripParameters(change_distance=1500.0),
}
"""What a user may believe of roads, rightly and wrongly."""
_RIGHT = "prior as it is"
_DRIVERS = {"usual": 1.0, "gentle": 0.5, "hard": 1.6}
"""Their accelerations over the usual ones; the seed tells which of them drives."""
_KNOWN_BIAS = "bias known"


@dataclass(frozen=True)
class Told:
    """Answers of one drive, M of them, with the truth at each."""

    road: list[str]
    used: Array
    """(M, 7)"""
    stddev: Array
    truth: Array
    proven: Array
    """(M,); NaN where nothing is proven."""
    proven_distance: Array
    """Distance since the proof, as it is told [m]."""
    true_distance: Array
    """The same by the truth."""
    lower: Array
    mu_max: Array
    since: Array
    speed: Array
    travelled: Array
    """By the truth [m]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add its own options."""
    parser.add_argument("--cars", type=count, default=40, help="random cars")
    parser.add_argument("--minutes", type=float, default=6.0, help="length of each drive")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first car")


def run(options: argparse.Namespace) -> list[Row]:
    """Drive, estimate, and return the rows."""
    seeds = range(options.first_seed, options.first_seed + options.cars)
    told = results_of(_drive_and_tell, [(seed, 60.0 * options.minutes) for seed in seeds], "drives")
    rows: list[Row] = []
    for name in _PARTS:
        rows += _used_rows(name, [each[_RIGHT] for each in told])
        rows += _used_rows(name, [each[_KNOWN_BIAS] for each in told], ", bias known to 0.05 m/s^2")
    rows += _proof_rows([each[_RIGHT] for each in told])
    for driver in _DRIVERS:
        by = [each[_RIGHT] for seed, each in zip(seeds, told, strict=True) if _driver_of(seed) == driver]
        rows += _sharpness_rows(driver, by) if by else []
    for belief in BELIEFS:
        rows += _lower_rows(belief, [each[belief] for each in told])
    return rows


def _driver_of(seed: int) -> str:
    return tuple(_DRIVERS)[seed % len(_DRIVERS)]


def _drive_and_tell(job: tuple[int, float]) -> dict[str, Told]:
    seed, seconds = job
    driven = drive(seed, seconds, _DRIVERS[_driver_of(seed)])
    vehicle = load_vehicle("compact_car")
    speed = _speeds(driven, vehicle)
    found = used_over(driven, speed, vehicle)
    told = {name: tell(driven, speed, found, belief) for name, belief in BELIEFS.items()}
    error = float(np.random.default_rng([seed, 12]).normal(0.0, _CALIBRATED))
    deviations = {**vehicle.accelerometer.deviations, "bias": Deviation(_CALIBRATED, SharedBy.ALL)}
    known = replace(vehicle.accelerometer, bias=driven.bias + error, deviations=deviations)
    of_known = used_over(driven, speed, replace(vehicle, accelerometer=known))
    return told | {_KNOWN_BIAS: tell(driven, speed, of_known, BELIEFS[_RIGHT])}


def used_over(driven: GripDrive, speeds: Array, vehicle: Vehicle) -> list[GripInUse | None]:
    """Return the friction in use at each sample, where it is due."""
    used, gains = FrictionUsed(vehicle), np.array([wheel.brake_gain for wheel in vehicle.wheels])
    found = []
    for k, time in enumerate(driven.time.tolist()):
        forward = vehicle.accelerometer.forward(_Reading(driven.forward[k], 0.0, 0.0))
        lateral, torques = (float(driven.leftward[k]), float(driven.yaw_rate[k])), gains * driven.pressure[k]
        found.append(used.update(_stamp(time), float(speeds[k]), forward, *lateral, torques, driven.wheel_speed[k]))
    return found


def _speeds(driven: GripDrive, vehicle: Vehicle) -> Array:
    """Speeds of the car [m/s], (N,): those of wheel_slip where it knows them, else the median of the wheels."""
    estimator, radii = SlipEstimator(vehicle), np.array(vehicle.radii)
    torques = driven.pressure * np.array([wheel.brake_gain for wheel in vehicle.wheels])
    found = np.median(driven.wheel_speed * radii, axis=1)
    for k, time in enumerate(driven.time.tolist()):
        forward = vehicle.accelerometer.forward(_Reading(driven.forward[k], 0.0, 0.0))
        (answer, *_) = estimator.update(
            _stamp(time), driven.wheel_speed[k], forward, (), torques[k], float(driven.yaw_rate[k])
        )
        if isfinite(answer.vehicle_speed) and estimator.car.variance < 1.0:
            found[k] = estimator.car.speed
    return found


def tell(
    driven: GripDrive, speeds: Array, used: Sequence[GripInUse | None], parameters: FrictionGripParameters
) -> Told:
    """Remember over a drive; `speeds` [m/s] and friction in use as estimated."""
    tail = 1.0 - parameters.lower_probability
    road = RoadMemory(parameters.prior, parameters.change_distance, parameters.proof_distance, tail)
    travelled = np.append(0.0, np.cumsum(driven.speed[1:] * np.diff(driven.time)))
    window = round(_CHANGED / float(driven.time[1] - driven.time[0]))
    rows, roads, last = [], [], float(driven.time[0])
    for k, time in enumerate(driven.time.tolist()):
        speed = float(speeds[k])
        road.drive(speed * (time - last))
        last = time
        found = used[k]
        if found is None:
            continue
        each = (found.vehicle, found.front, found.rear, *found.wheels)
        road.feel(found, _stamp(time))
        proof, bounds = road.proof(), road.bounds()
        proven_at = nan if proof is None else np.interp(proof.stamp / NANOSECONDS - 1.0, driven.time, travelled)
        truth = driven.used[max(k - window, 0) : k + 1].mean(axis=0)
        rows.append(
            [
                *(part.mu_used for part in each),
                *(part.stddev for part in each),
                *truth,
                nan if proof is None else proof.mu,
                nan if proof is None else road.distance - proof.distance,
                float(travelled[k] - proven_at),
                bounds.lower,
                float(driven.mu_max[k]),
                float(driven.since[k]),
                float(driven.speed[k]),
                float(travelled[k]),
            ]
        )
        roads.append(driven.road[k])
    table = np.array(rows)
    return Told(roads, table[:, :7], table[:, 7:14], table[:, 14:21], *table[:, 21:].T)


def _stamp(time: float) -> int:
    return round((time + 1.0) * NANOSECONDS)


@dataclass(frozen=True)
class _Reading:
    x: float
    y: float
    z: float


def _used_rows(name: str, told: list[Told], of: str = "") -> list[Row]:
    place = _PARTS.index(name)
    columns = slice(place, place + 1 if name != _PARTS[-1] else None)
    error = np.concatenate([(each.used - each.truth)[:, columns].ravel() for each in told])
    stddev = np.concatenate([each.stddev[:, columns].ravel() for each in told])
    covered = 100.0 * float(np.mean(np.abs(error) <= 1.96 * stddev))
    size = float(np.sqrt(np.mean(error**2)))
    judged = at_most(size, _RMS[name]) if name in _RMS else not_judged(size)
    return [
        {"quantity": f"friction used, {name}{of}: RMS", **judged},
        {"quantity": f"friction used, {name}{of}: 95 % intervals cover [%]", **at_least(covered, 94.0)},
    ]


def _proof_rows(told: list[Told]) -> list[Row]:
    """Rows of the proof; which road it is of is the truth's word, and what the message says of its age is judged."""
    over, too_young, known, sharp = [], [], [], []
    for each in told:
        has = np.isfinite(each.proven)
        begun = each.since - each.speed * _CHANGED
        of_this_road = each.true_distance <= begun
        over.append(((each.proven > each.mu_max) & of_this_road)[has])
        too_young.append((~of_this_road & (each.proven_distance < (1.0 - _ODOMETRY) * begun))[has])
        known.append(has)
        sharp.append(each.proven[has])
    return [
        {"quantity": "mu_proven above the road that it is of [% of time]", **at_most(_percent(over), 0.5)},
        {
            "quantity": "mu_proven of another road, told younger than 95 % of the change [% of time]",
            **at_most(_percent(too_young), 0.0),
        },
        {"quantity": "time with a proof [%]", **at_least(_percent(known), 95.0)},
        {"quantity": "mu_proven, median", **not_judged(float(np.median(np.concatenate(sharp))))},
    ]


def _sharpness_rows(driver: str, told: list[Told]) -> list[Row]:
    """Rows of what one kind of driver comes to know on each road."""
    proven, lower = (np.concatenate(each) for each in ([one.proven for one in told], [one.lower for one in told]))
    roads = np.array([road for each in told for road in each.road])
    return [
        {
            "quantity": f"mu_proven, median, {driver} driver, {road}",
            **not_judged(float(np.nanmedian(proven[roads == road]))),
            "of mu_lower": float(np.median(lower[roads == road])),
        }
        for road in dict.fromkeys(roads.tolist())
    ]


def _lower_rows(belief: str, told: list[Told]) -> list[Row]:
    """Rows of the lower bound, over the distance: a prior is one of roads, and a car is longer on a slippery one."""
    above = np.concatenate([each.lower > each.mu_max for each in told])
    lower = np.concatenate([each.lower for each in told])
    roads = np.array([road for each in told for road in each.road])
    weight = np.concatenate([each.speed for each in told])
    name = f"mu_lower above the truth, {belief}"
    every = 100.0 * float(np.average(above, weights=weight))
    judged = at_most(every, 5.0) if belief == _RIGHT else not_judged(every)
    rows: list[Row] = [{"quantity": f"{name}, all roads [% of distance]", **judged}]
    for road in dict.fromkeys(roads.tolist()):
        on = roads == road
        share = 100.0 * float(np.average(above[on], weights=weight[on]))
        median, of_all = float(np.median(lower[on])), 100.0 * float(weight[on].sum() / weight.sum())
        rows.append({"quantity": f"{name}, {road}", **not_judged(share), "median": median, "distance [%]": of_all})
    shares = [np.average(each.lower > each.mu_max, weights=each.speed) for each in told]
    return [*rows, {"quantity": f"{name}, worst drive", **not_judged(100.0 * float(max(shares)))}]


def _percent(flags: list[NDArray[np.bool_]]) -> float:
    return 100.0 * float(np.mean(np.concatenate(flags)))
