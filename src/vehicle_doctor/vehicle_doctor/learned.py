"""What the findings know of the car, as a vehicle file."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vehicle_doctor.finding import Finding, Verdict
from vehicle_doctor.vehicle_text import with_values
from vehicle_models.stated_deviations import stated_deviation
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle


def learned_values(findings: Sequence[Finding], vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """Return the values to write, with their deviations, by dotted key.

    A value that several signals tell is their mean, its deviation the largest with their spread. One that agrees with
    the file is left out where the file knows it better.
    """
    by_key: dict[str, list[tuple[float, float]]] = {}
    contradicted: set[str] = set()
    for finding in findings:
        for key, pair in finding.learned.items():
            by_key.setdefault(key, []).append(pair)
            if finding.verdict in (Verdict.WARN, Verdict.FAIL):
                contradicted.add(key)
    found = {}
    for key, pairs in by_key.items():
        values, deviations = np.array(pairs).T
        pair = float(values.mean()), float(np.hypot(deviations.max(), values.std()))
        stated = stated_stddev(vehicle, key)
        if key in contradicted or stated is None or pair[1] < stated:
            found[key] = pair
    return found


def stated_stddev(vehicle: Vehicle, key: str) -> float | None:
    """Return the deviation that the file states for a dotted key; None where it states none."""
    *path, name = key.split(".")
    part = vehicle.wheel(path[1]) if path[:1] == ["wheels"] else vehicle.accelerometer if path else vehicle
    return stated_deviation(part.deviations, name)


def learned_file(findings: Sequence[Finding], source: Path) -> str:
    """Return the text of the vehicle file with what was learned.

    Args:
        findings: of a drive of this car.
        source: its vehicle file.

    Raises:
        ParameterError: a value is not possible for a car.
    """
    text = source.read_text(encoding="utf-8")
    text = with_values(text, learned_values(findings, load_vehicle(source)))
    with TemporaryDirectory() as directory:
        trial = Path(directory, source.name)
        trial.write_text(text, encoding="utf-8")
        load_vehicle(trial)
    return text
