"""Location of the measured data, and the cars they were measured on.

They are not part of the project: --data names their directory, else the environment variable FRICTION_DATA, else
shared/data beside the repository. See the README of benchmarks for what each file is.
"""

import os
from pathlib import Path

from vehicle_models.vehicle_file import load_vehicle

BMW, IAC, TYRE_RIG = "bmw_m8_abs_stop_100hz.csv", "iac_av21_putnam_25hz.csv", "fsae_ttc_straight_line.csv"
BMW_M8 = load_vehicle("bmw_m8")
INDY_AV21 = load_vehicle("indy_av21")


def data_directory() -> Path:
    """FRICTION_DATA, or ../shared/data from where the command is run: beside the repository."""
    return Path(os.environ.get("FRICTION_DATA", Path("../shared/data").resolve()))
