"""Common parts of all commands: subcommands, numbers with limits, user errors as one line."""

import sys
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable, Collection, Mapping, Sequence
from importlib import import_module

_USER_ERROR = 2
_INTERRUPTED = 130
"""Exit code of a command that was interrupted, by the convention of shells."""
_LARGEST = 1e9
WITHOUT_ROSDEP_KEY = {
    **dict.fromkeys(("rosbags", "mcap", "lz4", "zstandard"), "rosbags mcap"),  # rosbags brings lz4 and zstandard
    **dict.fromkeys(("can", "cantools"), "python-can cantools"),
    "asammdf": "asammdf",
    "pyarrow": "pyarrow",
    **dict.fromkeys(("dask", "distributed", "fsspec", "h3"), "'dask[distributed]' fsspec h3 pyarrow"),
}
"""Libraries without a rosdep key, and the Python packages to install for each."""


class UserError(Exception):
    """An error of the user; commands print its text as one line and end with exit code 2."""


def command(run: Callable[[], int], *errors: type[Exception]) -> int:
    """Run a command; return its exit code.

    An error of the user is one line on stderr and exit code 2: UserError, OSError (a missing file, a full disk), a
    library that is not installed, and the exceptions in `errors`. So is Ctrl-C, with exit code 130, at any time.

    Args:
        run: returns the exit code.
        errors: further exceptions whose text is meant for the user.
    """
    of_user: tuple[type[Exception], ...] = (UserError, OSError, *errors)
    try:
        return run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return _INTERRUPTED
    except of_user as error:
        print(f"error: {' '.join(str(error).split()) or type(error).__name__}", file=sys.stderr)
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        if library not in WITHOUT_ROSDEP_KEY:
            raise
        print(f"error: this needs {library}: {install_line(library)}", file=sys.stderr)
    return _USER_ERROR


def install_line(library: str) -> str:
    """Return the command that installs a library that has no rosdep key."""
    return f"python3 -m pip install {WITHOUT_ROSDEP_KEY[library]}"


def split_ros_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split arguments into ours and those from --ros-args on (rclpy would remove OLD:=NEW from ours)."""
    given = list(arguments)
    at = given.index("--ros-args") if "--ros-args" in given else len(given)
    return given[:at], given[at:]


def run_subcommand(
    parser: ArgumentParser,
    commands: Mapping[str, tuple[str, str]],
    arguments: Sequence[str],
    nodes: Collection[str] = (),
) -> int:
    """Run one of several commands; only its module is imported.

    Args:
        parser: gets the commands.
        commands: module and description of each command by its name; the module has `add_arguments` and `run`.
        arguments: of the command line.
        nodes: commands that are nodes: their `run` takes the arguments of ROS, too.

    Returns:
        The exit code.
    """
    ours, of_ros = split_ros_arguments(arguments)
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    module = None
    for name, (module_name, text) in commands.items():
        described = subparsers.add_parser(name, help=text, description=text)
        if ours[:1] == [name]:
            module = import_module(module_name)
            module.add_arguments(described)
    options = parser.parse_args(ours)
    assert module is not None, "argparse refuses everything but a command in the first place"
    if options.command in nodes:
        return int(module.run(options, of_ros))
    if of_ros:
        parser.error(f"unrecognized arguments: {' '.join(of_ros)}")
    return int(module.run(options))


def positive(text: str) -> float:
    """Read a number above 0, at most 1e9, from the command line."""
    value = _finite(text)
    if value <= 0.0:
        raise ArgumentTypeError(f"{text} must be above 0")
    return value


def not_negative(text: str) -> float:
    """Read a number from 0 to 1e9 from the command line."""
    value = _finite(text)
    if value < 0.0:
        raise ArgumentTypeError(f"{text} must not be negative")
    return value


def count(text: str) -> int:
    """Read a whole number from 1 to 1e9 from the command line."""
    try:
        value = int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text} is not a whole number") from None
    if not 1 <= value <= _LARGEST:
        raise ArgumentTypeError(f"{text} must be at least 1, and at most 1e9")
    return value


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) <= _LARGEST:
        raise ArgumentTypeError(f"{text} is not a number of at most {_LARGEST:.0e}")
    return value
