"""Rolling radii of the wheels while nothing but the engine drives or drags them."""

from dataclasses import dataclass

import numpy as np

from vehicle_doctor.comparison import BLOCK, block_means
from vehicle_doctor.drive import Array, Drive
from vehicle_doctor.findings import Finding, Verdict, against_file
from vehicle_doctor.motion import Motion
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.vehicle import Deviations, SharedBy, Vehicle, specified_stddev

MIN_ROLLING_TIME = 4.0
"""Rolling time [s] below which there is no answer."""
_PARTS = 10
_GENTLE = 2.5


@dataclass(frozen=True)
class Rolling:
    """Rim of each of n wheels over the speed of the car."""

    ratio: Array
    """Without force, (n,)."""
    ratio_stddev: Array
    force_slip: Array
    """Change with the force that accelerates the car and overcomes its resistance, over its mass [s^2/m], (n,)."""
    force_slip_stddev: Array
    by_sensor: bool
    """Whether the speed is that of a sensor; else the mean of the rims."""


def rolling_of(drive: Drive, motion: Motion) -> Rolling | None:
    """Return the ratios of the rolling wheels; None where they roll for less than MIN_ROLLING_TIME.

    A driven wheel slips by the force it carries: its rim over those of the others is a line over that force where it is
    small, and its value without force is the ratio of the radii. What is left of curves has a sign that changes, and is
    smaller the faster the car is: a sample counts with the fourth power of its speed, and less the harder the tyres
    work along or across. A wheel without a signal has NaN.
    """
    vehicle = drive.vehicle
    speed, rate = motion.speed, motion.rate
    with np.errstate(invalid="ignore", divide="ignore"):
        use = motion.moving & ~motion.braking & (np.abs(rate) < _GENTLE) & motion.complete
        use &= speed > 5.0
        by_sensor = bool((np.isfinite(motion.measured) & use).sum() * motion.step > MIN_ROLLING_TIME)
        sound = np.isfinite(motion.rims).any(axis=0)
        rims = motion.rims[:, sound]
        reference = motion.measured if by_sensor else rims.mean(axis=1)
        ratios = rims / reference[:, None]
        resistance = (
            GRAVITY * vehicle.rolling_resistance + 0.5 * AIR_DENSITY * vehicle.drag_area * speed**2 / vehicle.mass
        )
        force = motion.smooth(motion.force, 0.2)
        known = use & np.isfinite(force)
        if known.any():  # it feels the hills, and its offset does not matter here
            use, rate = known, force - np.median((force - rate)[known & np.isfinite(rate)])
        load = rate + resistance
        across = speed * motion.turned
    columns = (*ratios.T, load, across, speed)
    blocks = np.column_stack([block_means(motion, column, use) for column in columns])
    blocks = blocks[np.isfinite(blocks).all(axis=1)]
    if blocks.shape[0] * BLOCK < MIN_ROLLING_TIME:
        return None
    line, stddev = (np.full((2, sound.size), np.nan) for _ in range(2))
    line[:, sound], stddev[:, sound] = _lines(blocks)
    stddev[0] = np.hypot(stddev[0], _of_curves(vehicle, motion, line[0], float(np.median(blocks[:, -1]))))
    return Rolling(line[0], stddev[0], line[1], stddev[1], by_sensor)


def _of_curves(vehicle: Vehicle, motion: Motion, ratios: Array, speed: float) -> float:
    """Return the deviation of a ratio by what is not known of the curves.

    Where nothing tells the turning, a difference of left and right that both axles share may be all of it.
    """
    if np.isfinite(motion.turning_stddev):
        return 0.5 * vehicle.track * motion.turning_stddev / speed
    differences = []
    for axle in ("front", "rear"):
        sides = {wheel.side: ratios[i] for i, wheel in enumerate(vehicle.wheels) if wheel.axle == axle}
        if len(sides) == 2 and np.isfinite(sides["left"] + sides["right"]):
            differences.append(0.5 * (sides["right"] - sides["left"]))
    if not differences or len(set(np.sign(differences))) > 1:
        return 0.0
    return float(np.abs(differences).min())


def _lines(blocks: Array) -> tuple[Array, Array]:
    """Return ratio without force and its change with force of each wheel, (2, n), and their deviations."""
    ratios, load, across, speed = blocks[:, :-3], blocks[:, -3], blocks[:, -2], blocks[:, -1]
    middle = np.median(ratios, axis=0)
    near = (np.abs(ratios - middle) < 0.06).all(axis=1)
    ratios, load = ratios[near], load[near]
    weight = speed[near] ** 4 / (1.0 + load**2 + across[near] ** 2)
    design = np.column_stack([np.ones_like(load), load])
    parts = np.arange(load.size) * _PARTS // max(load.size, 1)

    def fit(rows: np.ndarray) -> Array:
        root = np.sqrt(weight[rows])
        # a drive at a single force does not determine the slope: its prior is a stiff tyre's 0.3 % for 1 m/s^2
        prior = np.array([[0.0, 1e-2 * root.sum()]])
        a = np.vstack([design[rows] * root[:, None], prior])
        b = np.vstack([ratios[rows] * root[:, None], np.zeros((1, ratios.shape[1]))])
        return np.asarray(np.linalg.lstsq(a, b, rcond=None)[0])

    whole = fit(np.ones(load.size, dtype=bool))
    without = np.array([fit(parts != k) for k in range(_PARTS)])
    return whole, np.sqrt((_PARTS - 1) * np.var(without, axis=0))


_FLOOR = 5e-4
"""Deviation of a ratio of radii that no drive undercuts: wear, load and temperature within it."""
_UNEQUAL = 0.01
"""Share by which a single radius may differ from the others: tyres wear unequally."""


def check(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion with the radii that were learned.

    The common radius is that of the speed sensor; without one the wheels keep their median, whose deviation is that of
    the file.
    """
    vehicle = drive.vehicle
    rolling = rolling_of(drive, motion)
    if rolling is None:
        text = f"not determined: less than {MIN_ROLLING_TIME:.0f} s of rolling above 5 m/s"
        return [Finding("radius", "all", Verdict.NOTE, text, remedy="roll without braking")], motion
    free, stddev, has_sensor = rolling.ratio, rolling.ratio_stddev, rolling.by_sensor
    driven = [wheel.driven for wheel in vehicle.wheels]
    if not has_sensor:
        free = free / np.nanmedian(free)  # one wheel that is far off does not move the others
    specified_stddevs = [specified_stddev(wheel.deviations, "radius") for wheel in vehicle.wheels]
    common = 0.0 if has_sensor else max(each or 0.01 for each in specified_stddevs)
    found = []
    factors = 1.0 / free
    usual = float(np.nanmedian(factors))
    for i, wheel in enumerate(vehicle.wheels):
        if not np.isfinite(factors[i]):
            continue  # its signal is a finding of its own
        radius = wheel.radius * float(factors[i])
        relative = float(np.hypot(stddev[i], _FLOOR * (2.0 if driven[i] else 1.0)))
        uncertainty = radius * float(np.hypot(relative, common / wheel.radius))
        specified = specified_stddevs[i]
        against = "the speed sensor" if has_sensor else "the other wheels"
        change = 100.0 * (factors[i] - 1.0)
        verdict = against_file(radius, radius * relative, wheel.radius, specified, 0.004 * wheel.radius)
        of_one = specified if _is_own(wheel.deviations) else None  # what all wheels share explains no single one
        one = against_file(float(factors[i]) / usual, relative, 1.0, (of_one or 0.0) / wheel.radius, _UNEQUAL)
        verdict = one if one is Verdict.WARN else verdict
        text = f"{change:+.2f} % against the file, by {against}"
        if not has_sensor:
            text += "; their common scale is not determined without a speed sensor"
        found.append(
            Finding("radius", wheel.name, verdict, text, radius, uncertainty, "m",
                    "take the value into the vehicle file (--write)" if verdict is Verdict.WARN else "",
                    {f"wheels.{wheel.name}.radius": (radius, uncertainty)})
        )  # fmt: skip
    return found, motion.with_wheel_factors(factors)


def _is_own(deviations: Deviations) -> bool:
    found = deviations.get("radius")
    return found is not None and found.shared_by is not SharedBy.ALL
