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
import sysconfig
from pathlib import Path

TOOLS = Path(__file__).resolve().parent
# Where ROS is sourced these come from its own distribution: its message modules are compiled against that numpy.
FROM_THE_SYSTEM = {"numpy", "scipy", "matplotlib", "pyyaml", "setuptools"}

LOCAL_SETUP_SH = """\
# Written by tools/make_venv.py: ROS 2 Jazzy from Python wheels as a colcon underlay.
_underlay_prepend() {{
  eval "_underlay_value=\\"\\${{$1-}}\\""
  case ":$_underlay_value:" in
    *":$2:"*) ;;
    *) eval "export $1=\\"$2\\${{_underlay_value:+:\\$_underlay_value}}\\"" ;;
  esac
  unset _underlay_value
}}
{prepends}
unset -f _underlay_prepend
export ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
# The libraries are on LD_LIBRARY_PATH already: spare every python its second start.
export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
"""

SOURCE_OTHER = """\
# Written by tools/make_venv.py.
. "{path}"
"""


def wanted_stamp(prefix: Path, ros_sourced: bool) -> dict[str, str]:
    """Return the stamp of the wanted environment; ``content`` alone may change in place."""
    content = hashlib.sha256()
    for name in ("requirements.txt", "requirements-tools.in", "make_venv.py"):
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
    """Install the requirements; exit where that fails, after what pip says."""
    arguments = requirement_arguments(prefix, ros_sourced)
    print(f"Python packages: installing into {prefix}, about a minute ...", flush=True)
    # Python compiles what is imported; compiling everything now would hold the first demo up.
    pip = [str(prefix / "bin/python"), "-m", "pip", "install", "--quiet", "--no-compile"]
    log = ["--log", str(prefix / "pip.log")]
    if subprocess.run([*pip, *log, *arguments], env=env, check=False).returncode != 0:
        sys.exit(f"Python packages: failed, see {prefix / 'pip.log'}")


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
        make_underlay(prefix)
    (prefix / ".complete").write_text(json.dumps(wanted, indent=1))


def make_underlay(prefix: Path) -> None:
    """Turn an environment with the wheels of ROS 2 into a colcon underlay; a second time changes nothing.

    The wheels put libraries, CMake packages and the ament index where ROS expects them, below the prefix, but they lack
    the scripts one sources, and some of their CMake files name directories of the machine that built them.
    """
    site_packages = next(prefix.glob("lib/python*/site-packages"))
    numpy_include = next(site_packages.glob("numpy/*core/include"))
    repoint_include_directories(prefix, sysconfig.get_path("include"), str(numpy_include))
    write_setup_scripts(prefix, site_packages)


def repoint_include_directories(prefix: Path, python_include: str, numpy_include: str) -> int:
    """Point the include directories of exported CMake targets to this machine's headers.

    Args:
        prefix: root of the virtual environment.
        python_include: directory that holds Python.h.
        numpy_include: directory that holds numpy/arrayobject.h.

    Returns:
        The number of files changed (0 on a second run).
    """
    built_on = r"/opt/python/cp\d+-cp\d+t?"
    changed = 0
    for path in sorted(prefix.glob("share/*/cmake/*Export.cmake")):
        before = path.read_text()
        text = re.sub(rf"{built_on}/lib/[^;\"]*/numpy/_?core/include", lambda _: numpy_include, before)
        text = re.sub(rf"{built_on}/include/python[\w.]+", lambda _: python_include, text)
        if text != before:
            write_atomically(path, text)
            changed += 1
    return changed


def environment_entries(prefix: Path, site_packages: Path) -> list[tuple[str, Path]]:
    """Return the search paths of the underlay, in the order in which they are prepended (the last comes first)."""
    libraries = sorted(site_packages.glob("ros_*.libs"))
    return [
        ("AMENT_PREFIX_PATH", prefix),
        ("CMAKE_PREFIX_PATH", prefix),
        ("PYTHONPATH", site_packages),
        *(("LD_LIBRARY_PATH", directory) for directory in libraries),
        ("LD_LIBRARY_PATH", prefix / "lib"),
        ("PATH", prefix / "bin"),
    ]


def write_setup_scripts(prefix: Path, site_packages: Path) -> int:
    """Write ``local_setup.*`` (this prefix) and ``setup.*`` (the same: nothing lies below) and count the changes."""
    prepends = "\n".join(
        f'_underlay_prepend {name} "{directory}"' for name, directory in environment_entries(prefix, site_packages)
    )
    scripts = {"local_setup.sh": LOCAL_SETUP_SH.format(prepends=prepends)}
    for name in ("local_setup.bash", "local_setup.zsh", "setup.sh", "setup.bash", "setup.zsh"):
        scripts[name] = SOURCE_OTHER.format(path=prefix / "local_setup.sh")
    return sum(write_atomically(prefix / name, text) for name, text in scripts.items())


def write_atomically(path: Path, text: str) -> bool:
    """Write the text unless the file holds it already; a kill leaves the old file or the new one, never half."""
    if path.exists() and path.read_text() == text:
        return False
    temporary = path.with_name(f".{path.name}.new")
    temporary.write_text(text)
    temporary.replace(path)
    return True


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
