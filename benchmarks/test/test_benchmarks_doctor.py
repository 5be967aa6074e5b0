"""A short cut of the doctor's evaluation: faulty drives of `model: car`."""

from benchmarks.doctor.drives import FAULTS, driven
from benchmarks.doctor.part import named
from vehicle_doctor.checks.accelerometer import FLAT
from vehicle_doctor.examine import examine
from vehicle_doctor.findings import Verdict
from vehicle_models.vehicle_file import load_vehicle

SEED, SECONDS = 1, 90.0
NAMED = (
    *("wheels in rpm", "wheel backwards", "wheel copied", "radius -3 %", "accelerometer in g"),
    *("accelerometer backwards", "pressure in bar", "pressure that does not brake", "pressure 60 ms late"),
    *("wheels with gaps", "stamps go back", "speed in km/h"),
    *("front wheels exchanged", "axles exchanged", "a tooth missing"),
)


def test_faults_are_named_and_a_healthy_drive_gives_no_alarm() -> None:
    base = driven(load_vehicle("compact_car"), SEED, SECONDS).drive
    alarms = [each for each in examine(base, FLAT) if each.verdict in (Verdict.WARN, Verdict.FAIL)]
    assert not alarms
    missed = [name for name in NAMED if not named(FAULTS[name], examine(FAULTS[name].change(base), FLAT))]
    assert not missed
