"""Pytest plugin with the settings of every test run: middleware on this machine only, plots without a screen."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from importlib import import_module
from pathlib import Path

from hypothesis import settings

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(Path(__file__).with_name("discovery.xml"))
os.environ["MPLBACKEND"] = "Agg"
with suppress(ImportError):  # not on the path of every test
    import_module("friction_runtime")  # one BLAS thread, for the tests of algorithms too

# A shell starts background processes with SIGINT ignored; tests end their processes with it.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A shared machine is slow at times; that is not a failure.
settings.register_profile("workspace", deadline=None, print_blob=True)
settings.load_profile("workspace")
