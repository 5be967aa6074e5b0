"""Settings and domains of a test process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from hypothesis import settings

from friction_test_support.dds_client import own_domain


def test_the_plugin_keeps_the_middleware_on_this_machine_and_sets_no_deadline() -> None:
    assert Path(os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"]).is_file()
    assert os.environ["MPLBACKEND"] == "Agg"
    assert settings().deadline is None


def test_processes_that_begin_their_search_at_the_same_domain_get_different_ones() -> None:
    code = f"import os; os.getpid = lambda: {os.getpid()}; from friction_test_support.dds_client import own_domain"
    command = [sys.executable, "-c", f"{code}; print(own_domain())"]
    mine = own_domain()
    other = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert 1 <= mine <= 101
    assert int(other) != mine
