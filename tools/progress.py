"""One line of progress for a long command: what it does now and for how long. Standard library only."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path


class ProgressLine:
    """A status line: redrawn in place on a terminal, one line every ten seconds elsewhere."""

    def __init__(self, title: str) -> None:
        """Start the clock; every line begins with ``title``."""
        self.title = title
        self.started = time.monotonic()
        self.terminal = sys.stdout.isatty()
        self.shown = self.started if self.terminal else self.started - 10.0

    def show(self, text: str, *, final: bool = False) -> None:
        """Show the present step, or the result in the final line."""
        now = time.monotonic()
        if not (self.terminal or final or now - self.shown >= 10.0):
            return
        self.shown = now
        line = f"{self.title}: {text} [{now - self.started:.0f} s]"
        start, end = ("\r\033[K", "\n" if final else "") if self.terminal else ("", "\n")
        print(f"{start}{line[:150]}", end=end, flush=True)


def run_with_progress(
    title: str,
    command: list[str],
    log: Path,
    describe: Callable[[str], str | None],
    env: Mapping[str, str],
    directory: Path | None = None,
) -> int:
    """Run a command with its output in a log file and one line of progress on the terminal.

    Args:
        title: name of the step.
        command: program and arguments.
        log: file that receives the whole output.
        describe: turns an output line into the text to show, or None to keep the last one.
        env: environment of the command.
        directory: where the command runs; None for here.

    Returns:
        The exit status of the command.
    """
    status = ProgressLine(title)
    text = "starting"
    with (
        log.open("w") as output,
        subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=env,
            cwd=directory,
        ) as process,
    ):
        assert process.stdout is not None

        def read() -> None:
            nonlocal text
            for line in process.stdout or ():
                output.write(line)
                text = describe(line) or text

        reader = threading.Thread(target=read, daemon=True)
        reader.start()
        while reader.is_alive():
            status.show(text)
            reader.join(0.2)
        code = process.wait()
    status.show("done" if code == 0 else f"failed (whole log: {log})", final=True)
    return code
