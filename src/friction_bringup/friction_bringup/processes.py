"""Processes of the graph: started together, watched, and ended together, within two seconds on an idle machine."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

AT_ONCE = 3.0
"""Time [s] between SIGINT and SIGKILL; an idle machine ends every process within 1 s."""


class ProcessGroup:
    """A set of processes with a log file each.

    They do not belong to the terminal's foreground group, so that Ctrl-C reaches this process alone, which then ends
    them in order. If this process is killed, the system interrupts them.
    """

    def __init__(self, log_directory: Path) -> None:
        """Make the directory of the log files."""
        log_directory.mkdir(parents=True, exist_ok=True)
        self._log_directory = log_directory
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, command: Sequence[str], env: Mapping[str, str]) -> None:
        """Start a process.

        ``setpriv`` (util-linux) makes the system interrupt it if this process is killed; without that program it still
        starts.
        """
        guard = ["setpriv", "--pdeathsig", "INT", "--"] if shutil.which("setpriv", path=env.get("PATH")) else []
        with self.log(name).open("wb") as log:
            self._processes[name] = subprocess.Popen(
                [*guard, *command],
                env=dict(env),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def log(self, name: str) -> Path:
        """Log file of a process."""
        return self._log_directory / f"{name}.log"

    def pid(self, name: str) -> int:
        """Process id of a process."""
        return self._processes[name].pid

    def ended(self) -> dict[str, int]:
        """Exit codes of the processes that have ended, by name."""
        codes = {name: process.poll() for name, process in self._processes.items()}
        return {name: code for name, code in codes.items() if code is not None}

    def processor_times(self) -> dict[str, float]:
        """Time that each process still running has had a processor for, by name [s]."""
        found = {}
        for name, process in self._processes.items():
            if process.poll() is None:
                # after the name in brackets, which may hold spaces: user and system time are fields 14 and 15
                fields = Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
                found[name] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        return found

    def send(self, name: str, number: signal.Signals) -> None:
        """Send a signal to a process: SIGSTOP and SIGCONT make it stand and go on, SIGKILL ends it."""
        self._processes[name].send_signal(number)

    def stop(self, grace: float = AT_ONCE) -> list[str]:
        """Interrupt the processes that still run, kill those that do not end in time, return the names of those killed.

        Args:
            grace: time to end [s].
        """
        running = {name: process for name, process in self._processes.items() if process.poll() is None}
        for process in running.values():
            process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + grace
        killed = []
        for name, process in running.items():
            try:
                process.wait(max(deadline - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                killed.append(name)
        return killed
