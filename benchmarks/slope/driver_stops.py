"""The driver's stops of section 8.2.3 on a car with load transfer, by the shipped processors: bags/*_stop, other noise.

The truth is the slip lambda of the front left wheel against lambda_max of the road. A detection that is missing counts
as infinitely late, and one that comes early is judged by its slip.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.runner import Row, at_least, at_most, not_judged
from benchmarks.slope.detection import METHODS, Detection, Settings, detections
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, PlantSample
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Sensors
from friction_bags.experiments.stops import ACCELERATION_VARIANCE, STOPS, car_of_the_stops, drive
from friction_parameters.parameter import changed
from vehicle_models import burckhardt
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

LATEST = 130.0
"""Longest delay of a detection after the true crossing [ms], for 95 % of the seeds."""
SLIP_AT_DETECTION = (0.85, 1.2)
"""Published slip at a detection over lambda_max [-]."""
EARLIEST_REGAINED = -25.0
"""Longest time by which it may be regained before the slip is back [ms]: the window spans a release of 100 ms."""
LATEST_REGAINED = 150.0
"""Longest delay after the slip is back at lambda_max [ms]."""
MOST_FOR_INFORMATION = 20
"""Seeds of the rows that nothing judges; a 95th percentile takes more than 20, of which it would be the largest."""
OTHER_PITCH = {"1.35 Hz": 1.35, "1.65 Hz": 1.65}
"""Natural frequencies of a body of which the vehicle file says 1.5 Hz, for information."""


@dataclass(frozen=True)
class StopTruth:
    """True history of a stop."""

    samples: tuple[PlantSample, ...]
    up: float
    """Time at which the slip passes lambda_max [s]."""
    down: float
    """Time at which it is back [s]."""
    lambda_max: float

    @property
    def time(self) -> Array:
        """Times of the samples [s], shape (samples,)."""
        return np.arange(len(self.samples), dtype=np.float64) * SAMPLE_TIME


@cache
def true_stop(name: str, pitch_frequency: float) -> StopTruth:
    """Make a stop of the chapter's car whose body pitches at `pitch_frequency` [Hz]."""
    vehicle = replace(car_of_the_stops(), pitch_frequency=pitch_frequency)
    samples = tuple(sample for sample, _ in drive(STOPS[name], vehicle))
    lambda_max = float(burckhardt.peak(samples[0].theta[0])[0])
    above = np.array([sample.slip[0] for sample in samples]) - lambda_max
    first = int(np.argmax(above > 0.0))
    last = first + int(np.argmax(above[first:] <= 0.0))
    up, down = (SAMPLE_TIME * (k - above[k] / (above[k] - above[k - 1])) for k in (first, last))
    return StopTruth(samples, float(up), float(down), lambda_max)


def driver_stops(seeds: range, settings: Settings, done: Callable[[], None] = lambda: None) -> list[Row]:
    """Rows of what has to hold of each stop and method, and of cars that are not quite that of the file.

    Args:
        seeds: of the sensor noise.
        settings: parameters of the processors.
        done: called after each run.
    """
    vehicle = car_of_the_stops()
    printed = replace(settings, slope=changed(settings.slope, {"detector.load_transfer": False}))
    rows: list[Row] = []
    for name in STOPS:
        truth = true_stop(name, vehicle.pitch_frequency)
        found = [_stop(truth, vehicle, settings, seed, done) for seed in seeds]
        few = seeds[:MOST_FOR_INFORMATION]
        as_printed = [_stop(truth, vehicle, printed, seed, done) for seed in few]
        others = {
            label: [_stop(true_stop(name, frequency), vehicle, settings, seed, done) for seed in few]
            for label, frequency in OTHER_PITCH.items()
        }
        for method in METHODS:
            rows += _judged(name, method, truth, [each[method] for each in found])
            rows.append(_delay(name, method, truth, "(8.3) as printed", [each[method] for each in as_printed]))
            for label, runs in others.items():
                of_other = true_stop(name, OTHER_PITCH[label])
                rows.append(_delay(name, method, of_other, f"pitch {label}", [each[method] for each in runs]))
    return rows


def number_of_runs(seeds: range) -> int:
    """Return the number of runs that `driver_stops` makes."""
    return len(STOPS) * (len(seeds) + (1 + len(OTHER_PITCH)) * len(seeds[:MOST_FOR_INFORMATION]))


def _stop(
    truth: StopTruth, vehicle: Vehicle, settings: Settings, seed: int, done: Callable[[], None]
) -> dict[str, Detection]:
    sensors = Sensors(CHAPTER_NOISE, ACCELERATION_VARIANCE, 0.0, vehicle, seed)
    fed = (
        messages.sensors(
            (sample.index + 1) * SAMPLE_TIME_NS, vehicle, sensors.measure(sample), CHAPTER_NOISE, ACCELERATION_VARIANCE
        )
        for sample in truth.samples
    )
    found = detections(fed, truth.time, settings, vehicle, vehicle.wheel_names[0])
    done()
    return found


def _judged(name: str, method: str, truth: StopTruth, found: Sequence[Detection]) -> list[Row]:
    slips = np.array([each.slip for each in found]) / truth.lambda_max
    back = np.array([each.regained for each in found]) - truth.down
    low, high = SLIP_AT_DETECTION
    limits = {
        "slip at detection over lambda_max, smallest": at_least(float(np.min(slips)), low),
        "slip at detection over lambda_max, median": at_most(float(np.median(slips)), high),
        "slip at detection over lambda_max, largest": not_judged(float(np.max(slips))),
        "regained, earliest [ms]": at_least(1e3 * float(np.min(back)), EARLIEST_REGAINED),
        "regained, latest [ms]": at_most(1e3 * float(np.max(back)), LATEST_REGAINED),
    }
    delay = _delays(truth, found)
    head: Row = {"surface": name, "method": method}
    late = float(np.percentile(delay, 95.0, method="higher"))
    return [
        head | {"quantity": "delay, p95 [ms]", **at_most(late, LATEST)},
        head | {"quantity": "delay, median [ms]", **not_judged(float(np.median(delay)))},
        *(head | {"quantity": quantity, **limit} for quantity, limit in limits.items()),
    ]


def _delay(name: str, method: str, truth: StopTruth, what: str, found: Sequence[Detection]) -> Row:
    quantity = f"{what}: delay, median [ms]"
    median = float(np.median(_delays(truth, found)))
    return {"surface": name, "method": method, "quantity": quantity, **not_judged(median)}


def _delays(truth: StopTruth, found: Sequence[Detection]) -> Array:
    delays = 1e3 * (np.array([each.lost for each in found]) - truth.up)
    return np.where(np.isnan(delays), np.inf, delays)
