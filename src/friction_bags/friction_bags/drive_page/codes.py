"""What the numbers of states, commands, verdicts and signs stand for."""

import numpy as np
from friction_msgs.msg import BrakeCommand, SupervisorState

from friction_bags.drive_page.recorded_run import Array, Series

SIGNS = {-1: "beyond the peak", 0: "not known", 1: "stable side"}
STATES = {
    SupervisorState.S0: "S0, no braking",
    SupervisorState.S1: "S1, stable side: increase",
    SupervisorState.S21: "S21, beyond the peak: the release begins to act",
    SupervisorState.S22: "S22, beyond the peak: decrease",
}
"""States of Figure 8.1; the name stands before the comma."""
LAWS = {SupervisorState.LAW_SLOPE_SIGN: "slope sign", SupervisorState.LAW_CURVE: "curve"}
COMMANDS = {
    BrakeCommand.NONE: "none",
    BrakeCommand.INCREASE: "increase",
    BrakeCommand.HOLD: "hold",
    BrakeCommand.DECREASE: "decrease",
}
ENVELOPE = {0: "no release asked for", 1: "release allowed", 2: "release refused", 3: "cap"}
"""Verdict of the envelope on what the law asks for."""


def signs(slope: Series) -> Array:
    """Return the key of SIGNS at every sample of a friction_slope: 0 where it is not valid."""
    return np.where(slope["valid"] > 0.0, slope["sign"], 0.0)


def verdicts(supervisor: Series) -> Array:
    """Return the key of ENVELOPE at every sample of an abs_supervisor: the cap in force, else the evidence."""
    release = supervisor["release"]
    asked = np.where(release == SupervisorState.RELEASE_REFUSED, 2.0, 1.0)
    judged = np.where(release == SupervisorState.RELEASE_NOT_WANTED, 0.0, asked)
    return np.where(supervisor["cap"] == SupervisorState.CAP_NONE, judged, 3.0)
