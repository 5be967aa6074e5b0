"""Make the virtual environment .venv from the lock, and complete it as a colcon underlay.

A stamp, written last, holds what the environment was made from. With the right stamp nothing is done; after a change of
the lock the environment is updated in place; without a stamp (a set-up that was killed half-way) or with another Python
or place, it is made again from scratch, because pip takes a half-copied package for an installed one.

Usage: python3 tools/make_venv.py [--ros-sourced]   (normally through `make setup`)
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from progress import run_with_progress

TOOLS = Path(__file__).resolve().parent
# Where ROS is sourced these come from its own distribution: its message modules are compiled against that numpy.
FROM_THE_SYSTEM = {"numpy", "scipy", "matplotlib", "pyyaml", "setuptools"}


def wanted_stamp(prefix: Path, ros_sourced: bool) -> dict[str, str]:
    """Return the stamp of the wanted environment; ``content`` alone may change in place."""
    content = hashlib.sha256()
    for name in ("requirements.txt", "requirements-tools.in", "make_underlay.py"):
        content.update((TOOLS / name).read_bytes())
    return {
        "python": f"{sys.version} {sys.base_prefix}",
        "place": str(prefix),
        "ros": "sourced" if ros_sourced else "wheels",
        "content": content.hexdigest(),
    }


def read_stamp(prefix: Path) -> dict[str, str]:
    """Return the stamp of a finished environment, or an empty one."""
    try:
        stamp = json.loads((prefix / ".complete").read_text())
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) and (prefix / "bin/python").exists() else {}


def requirement_arguments(prefix: Path, ros_sourced: bool) -> list[str]:
    """Return the packages for pip: the whole lock, or only those that a sourced ROS does not have."""
    lock = TOOLS / "requirements.txt"
    if not ros_sourced:
        return ["-r", str(lock)]
    pins = [line for line in lock.read_text().splitlines() if not FROM_THE_SYSTEM & {line.split("==")[0]}]
    constraints = prefix / "constraints.txt"
    constraints.write_text("\n".join(pins))
    return ["-r", str(TOOLS / "requirements-tools.in"), "-c", str(constraints)]


def install(prefix: Path, ros_sourced: bool, env: dict[str, str]) -> None:
    """Install the requirements with one line of progress; exit with the end of the log where that fails."""
    collected = 0

    def describe(line: str) -> str | None:
        nonlocal collected
        if match := re.match(r"(?:Collecting|Requirement already satisfied:) ([\w.-]+)", line):
            collected += 1
            return f"{collected} packages, {match[1]}"
        return "copying into .venv" if line.startswith("Installing collected packages") else None

    log = prefix / "pip.log"
    # Python compiles what is imported; compiling everything now would hold the first demo up.
    command = [str(prefix / "bin/python"), "-m", "pip", "install", "--progress-bar=off", "--no-compile"]
    command += requirement_arguments(prefix, ros_sourced)
    if run_with_progress("Python packages", command, log, describe, env) != 0:
        sys.exit("".join(log.read_text().splitlines(keepends=True)[-12:]))


def make(prefix: Path, ros_sourced: bool) -> None:
    """Bring the environment to the state of the lock."""
    wanted, found = wanted_stamp(prefix, ros_sourced), read_stamp(prefix)
    if found == wanted:
        return
    env = dict(os.environ, PIP_DISABLE_PIP_VERSION_CHECK="1", _ROS_WHEELS_BOOTSTRAP_COMPLETE="1")
    if not ros_sourced:
        env.pop("PYTHONPATH", None)
    (prefix / ".complete").unlink(missing_ok=True)
    if {**found, "content": wanted["content"]} != wanted:
        if prefix.exists():
            print(f"{prefix} is unfinished, or was made elsewhere or for another Python: starting again.")
        shutil.rmtree(prefix, ignore_errors=True)
        options = ["--system-site-packages"] if ros_sourced else []
        # Not sys.executable: that may be the python of the environment just removed.
        base = Path(sys.base_prefix) / "bin" / f"python{sys.version_info.major}.{sys.version_info.minor}"
        subprocess.run([str(base), "-m", "venv", *options, str(prefix)], check=True, env=env)
    install(prefix, ros_sourced, env)
    if not ros_sourced:
        subprocess.run([str(prefix / "bin/python"), str(TOOLS / "make_underlay.py")], check=True, env=env)
    (prefix / ".complete").write_text(json.dumps(wanted, indent=1))


def main() -> None:
    """Parse the arguments and make the environment, one process at a time."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ros-sourced", action="store_true", help="ROS 2 Jazzy is sourced: add the tools alone")
    parser.add_argument("--prefix", type=Path, default=TOOLS.parent / ".venv", help="where the environment goes")
    args = parser.parse_args()
    directory = os.open(TOOLS, os.O_RDONLY)
    fcntl.flock(directory, fcntl.LOCK_EX)
    make(args.prefix.absolute(), args.ros_sourced)


if __name__ == "__main__":
    main()
