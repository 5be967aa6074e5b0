"""Settings of a run and the code that it runs, as one digest: results of other settings are other results."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

from friction_adapter.map_file import load_map, map_path
from friction_bags.offline.plan import ProcessOptions
from friction_runtime.source_digest import source_digest
from vehicle_models.vehicle_file import vehicle_path

ESTIMATORS = ("wheel_slip", "friction_curve_id", "friction_grip")
"""Estimators that the tables are made of."""
_PACKAGES = (
    *("friction_adapter", "friction_bags", "friction_parameters", "friction_runtime", "sensor_monitor"),
    *("vehicle_models", *ESTIMATORS),
)
_OWN = ("cells.py", "dataset.py", "places.py", "rows.py", "settings.py", "task.py")
_LIBRARIES = ("numpy", "scipy", "h3")


@dataclass(frozen=True)
class Settings:
    """What the user chooses; files are read by every worker at the same path."""

    vehicle: str = ""
    """Vehicle file or name of a shipped one; empty for that of each bag's note."""
    parameter_files: tuple[Path, ...] = ()
    map_file: str = ""
    """Signal map, or name of a shipped one; empty where bags hold the topics of this graph."""
    namespace: str = "/"

    def options(self, map_file: str) -> ProcessOptions:
        """Return the options of `friction_bags process`, with a map or without."""
        files = self.parameter_files
        return ProcessOptions(ESTIMATORS, self.vehicle, files, self.namespace, map_file=map_file)

    def digest(self) -> str:
        """Return the digest of code, libraries, options and the contents of all files.

        Raises:
            OSError: a file cannot be read.
            ParameterError: map or vehicle file are bad.
        """
        found = sha256(f"{code_digest()} {self.namespace} {self.vehicle} {self.map_file}".encode())
        files = list(self.parameter_files)
        if self.vehicle:
            files.append(vehicle_path(self.vehicle))
        if self.map_file:
            signal_map = load_map(self.map_file, self.vehicle)
            files += [map_path(self.map_file), vehicle_path(signal_map.vehicle_reference)]
            files += [signal_map.can.dbc] if signal_map.can.dbc is not None else []
        for file in files:
            found.update(sha256(file.read_bytes()).digest())
        return found.hexdigest()[:24]


@cache
def code_digest() -> str:
    """Return the digest of the sources and shipped files of all that the results depend on, and of the libraries."""
    own = [Path(__file__).with_name(name) for name in _OWN]
    return source_digest(_PACKAGES, _LIBRARIES, own)[:24]
