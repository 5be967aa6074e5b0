"""The doctor: every fault of faulty drives named, healthy drives without a false alarm, what it learns.

The drives are those of `model: car`, a plant that shares no code with the doctor; the vehicle file is compact_car, and
the cars are spread as its deviations say.
"""

import argparse
from math import hypot

import numpy as np
from rich.progress import track

from benchmarks.doctor.drives import FAULTS, PAIRS, Driven, InjectedFault, driven
from benchmarks.runner import Row, at_most, not_judged
from friction_parameters.command_line import count
from vehicle_doctor.checks.accelerometer import FLAT, UNKNOWN
from vehicle_doctor.checks.brakes import expected_gain
from vehicle_doctor.drive import Drive
from vehicle_doctor.examine import examine
from vehicle_doctor.findings import Finding, Verdict
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

_VEHICLE = "compact_car"
_SECONDS = 180.0
_FADED = 0.3
_SOON = 1e5
"""Work of a brake, that of a braking or two, at which it is lost early [J]."""
_ALL = len(FAULTS) + len(PAIRS) + 2
_COVERS = 3.0
"""Deviations within which a value that misses its limit must be."""
_ALARMS = (Verdict.WARN, Verdict.FAIL)
_BASES = 6
"""Drives that the faults share."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add its own options."""
    parser.add_argument("--healthy", type=count, default=20, help="healthy drives")
    parser.add_argument("--faulty", type=count, default=_ALL, help="faulty drives, singles first")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first drive")


def run(options: argparse.Namespace) -> list[Row]:
    """Drive, examine, and return the rows."""
    vehicle = load_vehicle(_VEHICLE)
    rows: list[Row] = []
    errors: dict[str, list[tuple[float, float]]] = {}
    for seed in track(range(options.first_seed, options.first_seed + options.healthy), "healthy"):
        base = driven(vehicle, seed, _SECONDS)
        findings = examine(base.drive, FLAT if base.flat else UNKNOWN)
        alarms = sum(each.verdict in _ALARMS for each in findings)
        rows.append(_row(f"healthy {seed}", findings, float(alarms)))
        for name, pair in _errors(base, findings, vehicle).items():
            errors.setdefault(name, []).extend(pair)
    rows += [row for name, pairs in errors.items() for row in _accuracy(name, pairs)]
    return rows + faulty_rows(vehicle, options.faulty, options.first_seed)


def faulty_rows(vehicle: Vehicle, most: int, first_seed: int = 0, seconds: float = _SECONDS) -> list[Row]:
    """Return a row of each faulty drive, with the number of faults that were not named."""
    cases: list[tuple[InjectedFault, ...]] = [(each,) for each in FAULTS.values()]
    cases += [tuple(FAULTS[name] for name in pair) for pair in PAIRS]
    seeds = [first_seed + 101 + 2 * k for k in range(_BASES)]  # odd ones are flat, so that a bias is determined
    bases: dict[int, Drive] = {}
    rows = []
    for number, faults in enumerate(track(cases[:most], "faulty")):
        seed = seeds[number % len(seeds)] | 1
        if seed not in bases:
            bases[seed] = driven(vehicle, seed, seconds).drive
        drive = bases[seed]
        for fault in faults:
            drive = fault.change(drive)
        findings = examine(drive, FLAT)
        missed = [each for each in faults if not named(each, findings)]
        rows.append(_row(" and ".join(each.name for each in faults), findings, float(len(missed))))
    return [*rows, *_faded_rows(vehicle, seeds[1] | 1, seconds)[: max(most - len(cases), 0)]]


def _faded_rows(vehicle: Vehicle, seed: int, seconds: float) -> list[Row]:
    """A fade over the drive must be named; one that is over after a braking or two is a lower gain, to be learned."""
    late = examine(driven(vehicle, seed, seconds, _FADED).drive, FLAT)
    missed = not any(each.check == "fade" and each.verdict in _ALARMS for each in late)
    base = driven(vehicle, seed, seconds, _FADED, _SOON)
    early = examine(base.drive, FLAT)
    ((error, stddev),) = _errors(base, early, vehicle)["gain over mass [%]"]
    unknown = abs(error) > max(_LIMITS["gain over mass [%]"], _COVERS * stddev)
    return [
        _row("brakes that fade", late, float(missed)),
        _row("brakes that have faded after the first brakings: error of the gain", early, float(unknown)),
    ]


def _row(drive: str, findings: list[Finding], missed: float) -> Row:
    said = "; ".join(f"{each.check} {each.subject}: {each.sentence}" for each in findings if each.verdict in _ALARMS)
    return {"drive": drive, "said": said, **at_most(missed, 0.0)}


def named(fault: InjectedFault, findings: list[Finding]) -> bool:
    """Whether a fault is among the alarms."""
    return any(
        each.check == fault.check
        and each.subject == fault.subject
        and each.verdict in _ALARMS
        and fault.word in each.sentence
        for each in findings
    )


def _errors(base: Driven, findings: list[Finding], vehicle: Vehicle) -> dict[str, list[tuple[float, float]]]:
    """Errors and deviations of what was learned, by quantity and in the unit of its limit."""
    truth, sensors = base.truth, base.truth.sensors
    by = {(each.check, each.subject): each for each in findings}
    found: dict[str, list[tuple[float, float]]] = {}

    def add(name: str, check: str, subject: str, true: float, scale: float = 1.0) -> None:
        finding = by.get((check, subject))
        if finding is not None and np.isfinite(finding.value):
            found.setdefault(name, []).append((scale * (finding.value - true), scale * finding.stddev))

    for name, radius in zip(vehicle.wheel_names, truth.radius, strict=True):
        add("radius [%]", "radius", name, radius, 100.0 / radius)
        topic = f"{name}/brake_pressure"
        add("age of the pressure [ms]", "skew", topic, 1e3 * (sensors.pressure_delay - base.wheel_age))
    add("age of the accelerometer [ms]", "skew", "imu/data", 1e3 * (sensors.acceleration_delay - base.wheel_age))
    add("age of the speed sensor [ms]", "skew", "vehicle_velocity", -1e3 * base.wheel_age)
    if base.flat:
        add("bias [m/s^2]", "bias", "imu/data", sensors.acceleration_bias)
    gain = sum(k / r for k, r in zip(truth.brake_gain, truth.radius, strict=True)) / truth.mass
    true = gain / expected_gain(vehicle) * (1.0 - truth.fading)
    add("gain over mass [%]", "gain", "brakes", true, 100.0 / true)
    return found


_LIMITS = {"radius [%]": 0.3, "bias [m/s^2]": 0.05, "gain over mass [%]": 3.0}
_AGE = 2.0


def _accuracy(name: str, pairs: list[tuple[float, float]]) -> list[Row]:
    """Return the share within the limit, and how many errors neither it nor the stated deviation covers."""
    error, stddev = np.abs(np.array(pairs)).T
    limit = _LIMITS.get(name, _AGE)
    uncovered = (error > limit) & (error > _COVERS * stddev)
    rms = hypot(*error) / error.size**0.5
    return [
        {"drive": f"{name}, RMS error of {error.size}", **not_judged(float(rms))},
        {"drive": f"{name}, share within {limit:g}", **not_judged(float((error <= limit).mean()))},
        {
            "drive": f"{name}, beyond {limit:g} and beyond {_COVERS:g} deviations",
            **at_most(float(uncovered.sum()), 0.0),
        },
    ]
