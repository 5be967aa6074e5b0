"""Grip: friction used, proven and left against the truth of a plant that shares no code with the estimator."""

import argparse
from dataclasses import dataclass
from math import nan
from os import cpu_count

import numpy as np
from numpy.typing import NDArray

from benchmarks.grip.drives import GripDrive, drive
from benchmarks.runner import Row, at_least, at_most, in_processes, not_judged
from friction_grip.friction_used import FrictionUsed
from friction_grip.parameters import FrictionGripParameters
from friction_grip.road_memory import RoadMemory
from friction_grip.road_prior import RoadPrior
from friction_parameters.command_line import count
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
_PARTS = ("car", "front", "rear")
_RMS = {"car": 0.015, "front": 0.02, "rear": 0.025}
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


@dataclass(frozen=True)
class Told:
    """Answers of one drive, M of them, with the truth at each."""

    road: list[str]
    used: Array
    """(M, 3)"""
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add its own options."""
    parser.add_argument("--cars", type=count, default=40, help="random cars")
    parser.add_argument("--minutes", type=float, default=6.0, help="length of each drive")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first car")


def run(options: argparse.Namespace) -> list[Row]:
    """Drive, estimate, and return the rows."""
    seeds = range(options.first_seed, options.first_seed + options.cars)
    told = in_processes(_drive_and_tell, [(seed, 60.0 * options.minutes) for seed in seeds], "drives", cpu_count() or 1)
    rows: list[Row] = []
    for name in _PARTS:
        rows += _used_rows(name, [each[_RIGHT] for each in told])
    rows += _proof_rows([each[_RIGHT] for each in told])
    for belief in BELIEFS:
        rows += _lower_rows(belief, [each[belief] for each in told])
    return rows


def _drive_and_tell(job: tuple[int, float]) -> dict[str, Told]:
    seed, seconds = job
    driven = drive(seed, seconds, (1.0, 0.5, 1.6)[seed % 3])
    vehicle = load_vehicle("compact_car")
    return {name: tell(driven, vehicle, belief) for name, belief in BELIEFS.items()}


def tell(driven: GripDrive, vehicle: Vehicle, parameters: FrictionGripParameters) -> Told:
    """Estimate over a drive."""
    used = FrictionUsed(vehicle)
    tail = 1.0 - parameters.lower_probability
    road = RoadMemory(parameters.prior, parameters.change_distance, parameters.proof_distance, tail)
    gains, radii = np.array([wheel.brake_gain for wheel in vehicle.wheels]), np.array(vehicle.radii)
    travelled = np.append(0.0, np.cumsum(driven.speed[1:] * np.diff(driven.time)))
    window = round(_CHANGED / float(driven.time[1] - driven.time[0]))
    rows, roads, last = [], [], float(driven.time[0])
    for k, time in enumerate(driven.time.tolist()):
        speed = float(np.median(driven.wheel_speed[k] * radii))
        road.drive(speed * (time - last))
        last = time
        forward = vehicle.accelerometer.forward(_Reading(driven.forward[k], 0.0, 0.0))
        stamp = round((time + 1.0) * NANOSECONDS)
        found = used.update(stamp, speed, forward, float(driven.leftward[k]), gains * driven.pressure[k])
        if found is None:
            continue
        each = (found.vehicle, found.front, found.rear)
        road.feel(found, stamp)
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
            ]
        )
        roads.append(driven.road[k])
    table = np.array(rows)
    return Told(roads, table[:, :3], table[:, 3:6], table[:, 6:9], *table[:, 9:].T)


@dataclass(frozen=True)
class _Reading:
    x: float
    y: float
    z: float


def _used_rows(name: str, told: list[Told]) -> list[Row]:
    place = _PARTS.index(name)
    error = np.concatenate([each.used[:, place] - each.truth[:, place] for each in told])
    stddev = np.concatenate([each.stddev[:, place] for each in told])
    covered = 100.0 * float(np.mean(np.abs(error) <= 1.96 * stddev))
    return [
        {"quantity": f"friction used, {name}: RMS", **at_most(float(np.sqrt(np.mean(error**2))), _RMS[name])},
        {"quantity": f"friction used, {name}: 95 % intervals cover [%]", **at_least(covered, 94.0)},
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
