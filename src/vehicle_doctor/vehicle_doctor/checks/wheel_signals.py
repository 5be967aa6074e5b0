"""Each wheel by itself: there or not, its sign, a copy of another one."""

import numpy as np

from vehicle_doctor.drive import WHEEL_STATES, Drive
from vehicle_doctor.finding import Finding, failure
from vehicle_doctor.motion import Motion, median_known

_COPY = 0.98
"""Share of samples of a moving car in which two wheels are equal that only a copy has."""


def check(drive: Drive, motion: Motion) -> tuple[list[Finding], Motion]:
    """Return the findings, and the motion with signs put right."""
    names = drive.vehicle.wheel_names
    found: list[Finding] = []
    size = median_known(np.abs(motion.rims))
    rolls = np.nan_to_num(size) > 1e-3
    factors = np.ones(len(names))
    for i, name in enumerate(names):
        rim = motion.rims[rolls, i]
        known = rim[np.isfinite(rim)]
        if not known.size:
            found.append(failure("wheel", name, "has no speed in wheel_states", "name its joint in the vehicle file"))
        elif np.ptp(known) == 0.0:
            found.append(failure("wheel", name, "never changes its speed", "look at its sensor"))
        elif np.median(known) < 0.0:
            factors[i] = -1.0
            found.append(failure("sign", name, "turns backwards while the car drives", "'sign: -1' in the signal map"))
    recorded = drive.topics[WHEEL_STATES].values
    changed = np.abs(np.diff(recorded, axis=0, prepend=recorded[:1])).max(axis=1) > 0.0
    live = recorded[changed]
    for i, first in enumerate(names):
        for j in range(i + 1, len(names)):
            pair = live[:, [i, j]]
            pair = pair[np.isfinite(pair).all(axis=1)]
            if pair.shape[0] > 50 and (pair[:, 0] == pair[:, 1]).mean() > _COPY:
                text = (
                    f"is a copy of {first}: equal in {100.0 * (pair[:, 0] == pair[:, 1]).mean():.0f} % of the samples"
                )
                remedy = "give each wheel its own field in the signal map"
                found.append(failure("duplicate", names[j], text, remedy))
    return found, motion.with_wheel_factors(factors)
