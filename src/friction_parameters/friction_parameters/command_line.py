"""Common parts of all commands: numbers with limits, user errors as one line."""

import sys
from argparse import ArgumentTypeError
from collections.abc import Callable

from friction_parameters.parameter import ParameterError

_MISTAKE = 2
_INTERRUPTED = 130
"""Exit code of a command that was interrupted, by the convention of shells."""
_LARGEST = 1e9


def command(run: Callable[[], int], *mistakes: type[Exception]) -> int:
    """Run a command; return its exit code.

    A mistake of the user is one line on stderr and exit code 2: ParameterError, OSError (a file that is not there, a
    full disk) and the exceptions in `mistakes`. So is Ctrl-C, with exit code 130, at any time.

    Args:
        run: returns the exit code.
        mistakes: further exceptions whose text is meant for the user.
    """
    users: tuple[type[Exception], ...] = (ParameterError, OSError, *mistakes)
    try:
        return run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return _INTERRUPTED
    except users as error:
        print(f"error: {' '.join(str(error).split()) or type(error).__name__}", file=sys.stderr)
        return _MISTAKE


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
