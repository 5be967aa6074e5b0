"""Processes start and end together."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from friction_bringup.processes import ProcessGroup

STUBBORN = (
    "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); print('ready', flush=True); time.sleep(600)"
)
POLITE = "import time\nprint('ready', flush=True)\ntry:\n  time.sleep(600)\nexcept KeyboardInterrupt:\n  print('bye')"


def wait_for(group: ProcessGroup, name: str, text: str) -> None:
    """Wait until a process has written the text to its log."""
    deadline = time.monotonic() + 120.0
    while text not in group.log(name).read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_stop_interrupts_and_kills_who_does_not_listen(tmp_path: Path) -> None:
    group = ProcessGroup(tmp_path / "log")
    group.start("polite", [sys.executable, "-c", POLITE], os.environ)
    group.start("stubborn", [sys.executable, "-c", STUBBORN], os.environ)
    for name in ("polite", "stubborn"):
        wait_for(group, name, "ready")
    assert group.ended() == {}
    assert group.stop() == ["stubborn"]
    assert group.ended() == {"polite": 0, "stubborn": -signal.SIGKILL}
    assert "bye" in group.log("polite").read_text()
    assert group.stop() == []


def test_processes_do_not_outlive_a_killed_parent(tmp_path: Path) -> None:
    parent = (
        "import os, pathlib, sys, time\nfrom friction_bringup.processes import ProcessGroup\n"
        f"group = ProcessGroup(pathlib.Path({str(tmp_path)!r}))\n"
        f"group.start('child', [sys.executable, '-c', {POLITE!r}], os.environ)\ntime.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", parent]) as process:
        log = tmp_path / "child.log"
        deadline = time.monotonic() + 120.0
        while not (log.exists() and "ready" in log.read_text()):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process.kill()
    while "bye" not in log.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)
