"""Radii of the wheels while nothing but the engine drives or drags them.

The common radius is that of the speed sensor; without one the wheels keep their median, whose deviation is that of the
file.
"""

import numpy as np

from vehicle_doctor.drive import Drive
from vehicle_doctor.finding import Finding, Verdict, against_file
from vehicle_doctor.motion import Motion
from vehicle_doctor.rolling import LEAST, rolling_of
from vehicle_models.stated_deviations import stated_deviation
from vehicle_models.vehicle import Deviations, SharedBy

_FLOOR = 5e-4
"""Deviation of a ratio of radii that no drive undercuts: wear, load and temperature within it."""
_UNEQUAL = 0.01
"""Share by which a single radius may differ from the others: tyres wear unequally."""


def check(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion with the radii that were learned."""
    vehicle = drive.vehicle
    rolling = rolling_of(drive, motion)
    if rolling is None:
        text = f"cannot be told: less than {LEAST:.0f} s of rolling above 5 m/s"
        return [Finding("radius", "all", Verdict.NOTE, text, remedy="roll without braking")], motion
    free, stddev, has_sensor = rolling.ratio, rolling.ratio_stddev, rolling.by_sensor
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
