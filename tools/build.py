"""Build the packages below src that changed with colcon, and compile their algorithms, with one line of progress.

A build that was killed, or was made elsewhere or by another Python, is removed first.
Usage: tools/run.bash python tools/build.py   [--sources-do]   (normally through `make build`)
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import json
import os
import re
import shutil
import sys
from pathlib import Path

from compile import COMPILED, compile_modules
from progress import run_with_progress

ROOT = Path(__file__).resolve().parents[1]
NOTHING_YET = "nothing yet"
"""Value of 'compiled by' in the stamp while the estimators run from their sources."""
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


def packages(source: Path) -> list[Path]:
    """Directories of the packages below ``source``."""
    return sorted(path.parent for path in source.glob("*/package.xml"))


def read_stamp(root: Path) -> dict[str, str]:
    """Return the stamp of the last build, empty where none has begun."""
    try:
        stamp = json.loads((root / "build" / ".friction_stamp").read_text())
    except (OSError, ValueError):
        return {}
    return {str(key): str(value) for key, value in stamp.items()} if isinstance(stamp, dict) else {}


def write_stamp(root: Path, stamp: dict[str, str]) -> None:
    """Note the state of the build in one step."""
    new = root / "build" / ".friction_stamp.new"
    new.write_text(json.dumps(stamp, indent=1))
    new.replace(root / "build" / ".friction_stamp")


def build(root: Path, must_compile: bool = True) -> int:
    """Bring ``install`` up to date; return the exit status.

    Args:
        root: root of the workspace.
        must_compile: False to run from sources as long as nothing has been compiled; afterwards changes are compiled.
    """
    made_by = f"{root} {sys.executable} {sys.version} {os.environ.get('AMENT_PREFIX_PATH', '').split(':')[-1]}"
    wanted = {package.name: source_digest(package) for package in packages(root / "src")}
    tools = hashlib.sha256((root / "tools/compile.py").read_bytes()).hexdigest()
    finished = {"made by": made_by, "state": "finished", "compiled by": tools, **wanted}
    found = read_stamp(root)
    sources_do = not must_compile and found.get("compiled by", NOTHING_YET) == NOTHING_YET
    if sources_do:
        finished["compiled by"] = NOTHING_YET
    if found == finished and (root / "install/setup.bash").exists():
        return 0
    colcon = shutil.which("colcon")
    if colcon is None:
        sys.exit("colcon is not on the PATH: sudo apt-get install -y python3-colcon-common-extensions")
    unfinished = found.get("state") != "finished" and (root / "build").exists()
    removed = not set(found) <= set(finished)
    if unfinished or removed or found.get("made by", made_by) != made_by or not (root / "install").exists():
        for name in ("build", "install"):
            shutil.rmtree(root / name, ignore_errors=True)
        found = {}
        sources_do = not must_compile
        finished["compiled by"] = NOTHING_YET if sources_do else tools
    (root / "build").mkdir(exist_ok=True)
    changed = [name for name, digest in wanted.items() if found.get(name) != digest]
    for name in changed:
        if (root / "src" / name / "setup.py").exists():  # setuptools would keep modules that are gone
            for directory in ("build", "install"):
                shutil.rmtree(root / directory / name, ignore_errors=True)
    write_stamp(root, {**finished, "state": "building"})
    code = run_colcon(colcon, root, changed) if changed else 0
    failed = changed if sources_do else [*changed, "compiled by"]
    if code == 0 and not sources_do and (COMPILED.keys() & changed or found.get("compiled by") != tools):
        code = compile_modules(root)
    # What failed is built again, as is what came after it.
    write_stamp(root, finished if code == 0 else {**finished, **dict.fromkeys(failed, "failed")})
    return code


def run_colcon(colcon: str, root: Path, names: list[str]) -> int:
    """Run colcon over the named packages; where one fails, print the end of its log."""
    done = 0
    failed: list[str] = []

    def describe(line: str) -> str | None:
        nonlocal done
        if match := re.match(r"Finished <<< (\S+)", line):
            done += 1
            return f"{done} of {len(names)} packages, {match[1]}"
        if match := re.match(r"Failed +<<< (\S+)", line):
            failed.append(match[1])
        return None

    log = root / "build" / "colcon.log"
    # By this python, so that the programs of the packages start with it too, wherever colcon comes from.
    command = [sys.executable, colcon, "--log-base", str(root / "log"), "build"]
    command += ["--base-paths", "src", "--packages-select", *names]
    env = dict(os.environ, PYTHONUNBUFFERED="1")
    code = run_with_progress("colcon build", command, log, describe, env)
    for package in failed:
        package_log = root / "log/latest_build" / package / "stdout_stderr.log"
        print(f"--- {package}: the end of {package_log}", *package_log.read_text().splitlines()[-25:], sep="\n")
    if code != 0 and not failed:
        print(*log.read_text().splitlines()[-25:], sep="\n")
    return code


def main() -> None:
    """Build, one process at a time, from the root of the workspace."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sources-do", action="store_true", help="compile nothing if nothing has been compiled yet")
    args = parser.parse_args()
    os.chdir(ROOT)
    directory = os.open(ROOT / "tools", os.O_RDONLY)
    fcntl.flock(directory, fcntl.LOCK_EX)
    code = build(ROOT, must_compile=not args.sources_do)
    if code == 0 and read_stamp(ROOT)["compiled by"] == NOTHING_YET:
        print("The estimators run from their Python sources: the same results, slower. `make build` compiles them.")
    sys.exit(code)


if __name__ == "__main__":
    main()
