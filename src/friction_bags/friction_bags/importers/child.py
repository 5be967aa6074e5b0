"""Runs a reader in a process of its own: a library in C may crash on a damaged file, and its process with it."""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, Final

from friction_bags.bag_io.bag_format import BagError

_ITEM, _ERROR, _END = "item", "error", "end"
_CHILD: Final = "from friction_bags.importers.child import serve; serve()"


def from_child(reader: Callable[..., Iterator[Any]], path: Path, *arguments: Any) -> Iterator[Any]:
    """Yield what a reader yields of a file.

    Args:
        reader: function of a module, called with the file and the arguments; all it takes and yields can be pickled.
        path: the file.
        arguments: more arguments.

    Raises:
        BagError: the reader has raised something, or its process has died.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", _CHILD]
    pipe, none = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, stderr=none) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            with process.stdin as stream:
                pickle.dump((reader, path, arguments), stream)
            while True:
                try:
                    kind, content = pickle.load(process.stdout)
                except (EOFError, pickle.UnpicklingError):
                    raise BagError(f"{path} is damaged: its reader has crashed on it") from None
                if kind == _ERROR:
                    raise BagError(f"{path} cannot be read, or not to its end: {content}")
                if kind == _END:
                    return
                yield content
        finally:
            process.kill()


def serve() -> None:
    """Read what the parent asks for; what libraries print goes nowhere."""
    reader, path, arguments = pickle.load(sys.stdin.buffer)
    with os.fdopen(os.dup(1), "wb") as stream:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        _serve(stream, reader, path, arguments)


def _serve(stream: BinaryIO, reader: Callable[..., Iterator[Any]], path: Path, arguments: tuple[Any, ...]) -> None:
    try:
        for item in reader(path, *arguments):
            pickle.dump((_ITEM, item), stream)
    except Exception as error:  # whatever libraries raise goes to the user as text
        pickle.dump((_ERROR, str(error) or repr(error)), stream)
    else:
        pickle.dump((_END, None), stream)
