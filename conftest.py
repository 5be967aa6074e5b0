"""Settings of every test run, however pytest is started: the middleware stays on this machine, plots need no screen."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from hypothesis import settings

# What local_discovery() of friction_bringup gives; its package is not on the path of every test.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(Path(__file__).parent / "src/friction_bringup/config/discovery.xml")
os.environ["MPLBACKEND"] = "Agg"
os.environ.setdefault("OMP_NUM_THREADS", "1")

# A shell starts background processes with SIGINT ignored; tests end their processes with it.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A shared machine is slow at times; that is not a failure.
settings.register_profile("workspace", deadline=None, print_blob=True)
settings.load_profile("workspace")
