"""Build the packages below src that changed with colcon.

A build that was killed, or was made elsewhere or by another Python, is removed first; so are packages that are gone.
Usage: tools/run.bash python tools/build.py   (normally through `make build`)
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IGNORED = {"__pycache__", "test", ".mypy_cache", ".ruff_cache", ".pytest_cache", ".hypothesis"}


def source_digest(package: Path) -> str:
    """Digest of the inputs of a package's build: names and contents of its files, without tests and prose."""
    digest = hashlib.sha256()
    for directory, subdirectories, names in os.walk(package):
        subdirectories[:] = sorted(
            name for name in subdirectories if name not in IGNORED and not name.endswith(".egg-info")
        )
        for path in sorted(Path(directory, name) for name in names):
            if path.suffix != ".md":
                digest.update(f"{path.relative_to(package)}\n".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def build(root: Path) -> int:
    """Bring ``install`` up to date; return the exit status."""
    stamp = root / "build" / ".friction_stamp"
    made_by = f"{root} {sys.executable} {sys.version} {os.environ.get('AMENT_PREFIX_PATH', '').split(':')[-1]}"
    wanted = {path.parent.name: source_digest(path.parent) for path in sorted((root / "src").glob("*/package.xml"))}
    found = _read(stamp)
    if found.get("made by") != made_by or found.get("state") != "finished" or not (root / "install").exists():
        for name in ("build", "install"):
            shutil.rmtree(root / name, ignore_errors=True)
        found = {}
    changed = [name for name, digest in wanted.items() if found.get(name) != digest]
    gone = found.keys() - wanted - {"made by", "state"}
    if not changed and not gone:
        return 0
    for name in [*changed, *gone]:
        if not (root / "src" / name / "CMakeLists.txt").exists():  # setuptools would keep modules that are gone
            for directory in ("build", "install"):
                shutil.rmtree(root / directory / name, ignore_errors=True)
    (root / "build").mkdir(exist_ok=True)
    _write(stamp, {**found, "made by": made_by, "state": "building"})
    colcon = shutil.which("colcon")
    if colcon is None:
        sys.exit("colcon is not on the PATH: sudo apt-get install -y python3-colcon-common-extensions")
    # By this python, so that the programs of the packages start with it too, wherever colcon comes from.
    command = [sys.executable, colcon, "--log-base", str(root / "log"), "build", "--base-paths", "src"]
    env = dict(os.environ)
    for name in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"):  # colcon warns of directories that are gone
        env[name] = os.pathsep.join(filter(os.path.isdir, env.get(name, "").split(os.pathsep)))
    code = subprocess.run([*command, "--packages-select", *changed], cwd=root, env=env).returncode if changed else 0
    # What failed is built again, as is what came after it.
    built = wanted if code == 0 else {**wanted, **dict.fromkeys(changed, "failed")}
    _write(stamp, {**built, "made by": made_by, "state": "finished"})
    return code


def _read(stamp: Path) -> dict[str, str]:
    """Return the stamp of the last build, empty where none has begun."""
    try:
        found = json.loads(stamp.read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _write(stamp: Path, content: dict[str, str]) -> None:
    """Write the stamp in one step: a kill leaves the old one or the new one."""
    new = stamp.with_suffix(".new")
    new.write_text(json.dumps(content, indent=1))
    new.replace(stamp)


if __name__ == "__main__":
    fcntl.flock(os.open(ROOT / "tools", os.O_RDONLY), fcntl.LOCK_EX)  # one build at a time
    sys.exit(build(ROOT))
