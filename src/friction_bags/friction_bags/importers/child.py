"""Runs a reader in a process of its own: a library in C may crash on a damaged file, and its process with it."""

import multiprocessing
import os
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from friction_bags.bag_io.bag_format import BagError

_ITEM, _ERROR, _END = "item", "error", "end"


def from_child(reader: Callable[..., Iterator[Any]], path: Path, *arguments: Any) -> Iterator[Any]:
    """Yield what a reader yields of a file.

    Args:
        reader: function of a module, called with the file and the arguments; all it takes and yields can be pickled.
        path: the file.
        arguments: more arguments.

    Raises:
        BagError: the reader has raised something, or its process has died.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(theirs, reader, path, arguments), daemon=True)
    process.start()
    theirs.close()
    try:
        while True:
            try:
                kind, content = ours.recv()
            except EOFError:
                raise BagError(f"{path} is damaged: its reader has crashed on it") from None
            if kind == _ERROR:
                raise BagError(f"{path} cannot be read, or not to its end: {content}")
            if kind == _END:
                return
            yield content
    finally:
        ours.close()
        process.terminate()
        process.join()


def _send(pipe: Connection, reader: Callable[..., Iterator[Any]], path: Path, arguments: tuple[Any, ...]) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what a library prints as it dies tells nobody anything
    try:
        for item in reader(path, *arguments):
            pipe.send((_ITEM, item))
    except Exception as error:  # whatever libraries raise goes to the user as text
        pipe.send((_ERROR, str(error) or repr(error)))
    else:
        pipe.send((_END, None))
