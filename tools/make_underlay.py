"""Turn the virtual environment with the ROS 2 wheels into an ordinary colcon underlay.

The wheels put libraries, CMake packages and the ament index where ROS expects them, below the prefix of the
environment, but they lack the scripts one sources, and some of their CMake files name directories of the machine
that built them. This script adds the former and repairs the latter; it changes nothing on a second run.

Usage: python tools/make_underlay.py   (with the Python of the environment to complete)
"""

from __future__ import annotations

import re
import sys
import sysconfig
from pathlib import Path

LOCAL_SETUP_SH = """\
# Written by tools/make_underlay.py: ROS 2 Jazzy from Python wheels as a colcon underlay.
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
# Written by tools/make_underlay.py.
. "{path}"
"""


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
    """Complete the environment of the running interpreter."""
    if sys.prefix == sys.base_prefix:
        sys.exit("make_underlay: run me with the python of a virtual environment, not with the system's")
    import numpy  # after the check: the system's python may not have it

    prefix = Path(sys.prefix)
    site_packages = Path(sysconfig.get_path("purelib"))
    mended = repoint_include_directories(prefix, sysconfig.get_path("include"), numpy.get_include())
    written = write_setup_scripts(prefix, site_packages)
    print(f"underlay {prefix}: {mended} CMake files mended, {written} set-up scripts written")


if __name__ == "__main__":
    main()
