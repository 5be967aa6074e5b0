"""A built checkout of this repository, this one or another: its commands, each in the environment of its own."""

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

_RUN = Path("tools", "run.bash")
_PATH_LISTS = (
    "PATH",
    "PYTHONPATH",
    "LD_LIBRARY_PATH",
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
)
_LAST_LINES = 5


class CheckoutError(RuntimeError):
    """A command of a checkout failed; the text holds the end of its output."""


@dataclass(frozen=True)
class Checkout:
    """A directory that holds the repository, built with `make build`."""

    root: Path

    def process(self, bag: Path, out: Path, parameter_files: Sequence[Path]) -> None:
        """Run its estimators over a bag and write their estimates.

        The car is not given: it is that of the bag's note or, in a checkout from before such notes, that of the
        parameter files.

        Args:
            bag: to be read.
            out: bag to be made.
            parameter_files: over those that the packages ship, the later decides.

        Raises:
            CheckoutError: there is no checkout, or the command failed.
        """
        command = ["python", "-m", "friction_bags", "process", str(bag.absolute()), "--out", str(out.absolute())]
        for file in parameter_files:
            command += ["--params-file", str(file.absolute())]
        self._run([*command, "--outputs-only"], out.parent)

    def _run(self, command: list[str], directory: Path) -> None:
        root = self.root.absolute()
        if not (root / _RUN).is_file():
            raise CheckoutError(f"{root} is no checkout: it has no {_RUN}")
        made = subprocess.run(
            [root / _RUN, *command], cwd=directory, env=_outer_environment(), capture_output=True, text=True
        )
        if made.returncode:
            output = "\n".join((made.stderr or made.stdout).splitlines()[-_LAST_LINES:])
            raise CheckoutError(f"{root}: {' '.join(command)} ended with code {made.returncode}:\n{output}")


def _outer_environment() -> dict[str, str]:
    """Return the environment without the paths of a checkout: its ROS would be taken for that of the user."""
    environment = dict(os.environ)
    for name in _PATH_LISTS:
        if name in environment:
            kept = [path for path in environment[name].split(os.pathsep) if path and not _in_checkout(Path(path))]
            environment[name] = os.pathsep.join(kept)
    return {name: value for name, value in environment.items() if value or name not in _PATH_LISTS}


def _in_checkout(path: Path) -> bool:
    return any((directory / _RUN).is_file() for directory in (path, *path.parents))
