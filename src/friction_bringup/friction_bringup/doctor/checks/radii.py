"""Radii of the wheels while nothing but the engine drives or drags them.

A driven wheel slips by the force it carries: its rim over those of the others is a line over that force where it is
small, and its value without force is the ratio of the radii. In curves the wheels of a side share a sign that changes,
and that is smaller the faster the car is: a sample counts with the fourth power of its speed. The common radius is that
of the speed sensor; without one the wheels keep their median, whose deviation is that of the file.
"""

import numpy as np

from friction_bringup.doctor.drive import Array, Drive
from friction_bringup.doctor.finding import Finding, Verdict, against_file
from friction_bringup.doctor.motion import Motion
from vehicle_models.single_corner import GRAVITY
from vehicle_models.stated_deviations import stated_deviation
from vehicle_models.vehicle import AIR_DENSITY, Deviations, SharedBy

_LEAST = 4.0
"""Rolling time [s] below which there is no answer."""
_BLOCK = 0.5
_PARTS = 10
_GENTLE = 2.5
_FLOOR = 5e-4
"""Deviation of a ratio of radii that no drive undercuts: wear, load and temperature within it."""
_UNEQUAL = 0.01
"""Share by which a single radius may differ from the others: tyres wear unequally."""


def check(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion with the radii that were learned."""
    vehicle = drive.vehicle
    speed, rate = motion.speed, motion.rate
    with np.errstate(invalid="ignore", divide="ignore"):
        use = motion.moving & ~motion.braking & (np.abs(rate) < _GENTLE) & np.isfinite(motion.rims).all(axis=1)
        use &= speed > 5.0
        has_sensor = bool((np.isfinite(motion.measured) & use).sum() * motion.step > _LEAST)
        reference = motion.measured if has_sensor else motion.rims.mean(axis=1)
        ratios = motion.rims / reference[:, None]
        resistance = (
            GRAVITY * vehicle.rolling_resistance + 0.5 * AIR_DENSITY * vehicle.drag_area * speed**2 / vehicle.mass
        )
        force = motion.smooth(motion.force, 0.2)
        known = use & np.isfinite(force)
        if known.any():  # it feels the hills, and its offset does not matter here
            use, rate = known, force - np.median((force - rate)[known & np.isfinite(rate)])
        load = rate + resistance
    blocks = _blocks(np.column_stack([ratios, load, speed]), use, max(round(_BLOCK / motion.step), 2))
    if blocks.shape[0] * _BLOCK < _LEAST:
        text = f"cannot be told: {blocks.shape[0] * _BLOCK:.1f} s of rolling above 5 m/s, {_LEAST:.0f} s needed"
        return [Finding("radius", "all", Verdict.NOTE, text, remedy="roll without braking")], motion
    free, stddev = _without_force(blocks)
    driven = [wheel.driven for wheel in vehicle.wheels]
    if not has_sensor:
        free = free / np.median(free)  # one wheel that is far off does not move the others
    stated_stddevs = [stated_deviation(wheel.deviations, "radius") for wheel in vehicle.wheels]
    common = 0.0 if has_sensor else max(each or 0.01 for each in stated_stddevs)
    found = []
    factors = 1.0 / free
    usual = float(np.median(factors))
    for i, wheel in enumerate(vehicle.wheels):
        radius = wheel.radius * float(factors[i])
        relative = float(np.hypot(stddev[i], _FLOOR * (2.0 if driven[i] else 1.0)))
        doubt = radius * float(np.hypot(relative, common / wheel.radius))
        stated = stated_stddevs[i]
        against = "the speed sensor" if has_sensor else "the other wheels"
        change = 100.0 * (factors[i] - 1.0)
        verdict = against_file(radius, radius * relative, wheel.radius, stated, 0.004 * wheel.radius)
        of_one = stated if _is_own(wheel.deviations) else None  # what all wheels share explains no single one
        one = against_file(float(factors[i]) / usual, relative, 1.0, (of_one or 0.0) / wheel.radius, _UNEQUAL)
        verdict = one if one is Verdict.WARN else verdict
        text = f"{change:+.2f} % against the file, by {against}"
        if not has_sensor:
            text += "; the size of all cannot be told without a speed sensor"
        found.append(
            Finding("radius", wheel.name, verdict, text, radius, doubt, "m",
                    "take the value into the vehicle file (--write)" if verdict is Verdict.WARN else "",
                    {f"wheels.{wheel.name}.radius": (radius, doubt)})
        )  # fmt: skip
    return found, motion.with_wheel_factors(factors)


def _is_own(deviations: Deviations) -> bool:
    found = deviations.get("radius")
    return found is not None and found.shared_by is not SharedBy.ALL


def _blocks(columns: Array, use: np.ndarray, width: int) -> Array:
    count = columns.shape[0] // width
    kept = np.where(use[:, None], columns, np.nan)[: count * width]
    means = kept.reshape(count, width, -1).mean(axis=1)
    return np.asarray(means[np.isfinite(means).all(axis=1)])


def _without_force(blocks: Array) -> tuple[Array, Array]:
    """Return ratio without force and its deviation of each wheel, by lines over the force, each part left out once."""
    ratios, load, speed = blocks[:, :-2], blocks[:, -2], blocks[:, -1]
    middle = np.median(ratios, axis=0)
    near = (np.abs(ratios - middle) < 0.06).all(axis=1)
    ratios, load, weight = ratios[near], load[near], speed[near] ** 4 / (1.0 + load[near] ** 2)
    design = np.column_stack([np.ones_like(load), load])
    parts = np.arange(load.size) * _PARTS // max(load.size, 1)

    def fit(rows: np.ndarray) -> Array:
        root = np.sqrt(weight[rows])
        # a drive at one force says nothing of its effect: a stiff tyre's 0.3 % for 1 m/s^2 is the prior of the slope
        prior = np.array([[0.0, 1e-2 * root.sum()]])
        a = np.vstack([design[rows] * root[:, None], prior])
        b = np.vstack([ratios[rows] * root[:, None], np.zeros((1, ratios.shape[1]))])
        return np.asarray(np.linalg.lstsq(a, b, rcond=None)[0][0])

    whole = fit(np.ones(load.size, dtype=bool))
    without = np.array([fit(parts != k) for k in range(_PARTS)])
    return whole, np.sqrt((_PARTS - 1) * np.var(without, axis=0))
