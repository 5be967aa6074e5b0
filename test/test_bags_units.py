"""No recorded drive, simulated or measured, has a unit suspected: all of them are in the right ones."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from friction_msgs.msg import FrictionCurve, FrictionSlope, WheelSlip

from friction_adapter.map_file import load_map
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_io.cdr import decode
from friction_bags.importers.table import Table
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("FRICTION_DATA", ROOT.parent / "shared" / "data"))
KINDS = {"slip": WheelSlip, "friction_slope": FrictionSlope, "friction_curve": FrictionCurve}
SUSPECTS = ("in bar", "converted from bar", "MPa", "in g", "wrong sign", "km/h", "miles", "revolutions", "in m/s")
CAR_METHOD = "friction_curve_id: {ros__parameters: {method: car}}\n"


def texts(bag: Path, directory: Path, vehicle: str, estimators: tuple[str, ...]) -> Iterator[str]:
    """Yield the reasons of the estimates, with the method car too where there are curves: it looks at every unit."""
    (directory / "car.yaml").write_text(CAR_METHOD)
    methods: dict[str, tuple[Path, ...]] = {"auto": (), "car": (directory / "car.yaml",)}
    if estimators:
        del methods["car"]
    for name, files in methods.items():
        options = ProcessOptions(estimators, vehicle, files, outputs_only=True)
        process_bag(bag, directory / name, options, 1, lambda _: None)
        with BagReader(directory / name) as reader:
            for topic, _, data in reader.messages():
                kind: Any = KINDS.get(topic.name.rpartition("/")[2])
                if kind is not None:
                    yield decode(data, kind).validity.text


def assert_no_unit_is_suspected(
    bag: Path, directory: Path, vehicle: str = "", estimators: tuple[str, ...] = ()
) -> None:
    said = set(texts(bag, directory, vehicle, estimators))
    assert said
    assert not [text for text in said if any(suspect in text for suspect in SUSPECTS)]


@pytest.mark.parametrize(
    "name", ["abs_stop", "cobblestone", "dry", "dry_to_snow", "high_grip_stop", "low_grip_stop", "snow", "wet"]
)
def test_no_unit_of_a_recorded_experiment_is_suspected(name: str, tmp_path: Path) -> None:
    assert_no_unit_is_suspected(ROOT / "bags" / name, tmp_path)


@pytest.mark.parametrize(
    ("signal_map", "file", "vehicle"),
    [("bmw", "bmw_m8_abs_stop_100hz.csv", "bmw_m8"), ("iac", "iac_av21_putnam_25hz.csv", "indy_av21")],
)
def test_no_unit_of_a_measured_drive_is_suspected(signal_map: str, file: str, vehicle: str, tmp_path: Path) -> None:
    """There are no pressures in them, so no curves."""
    if not (DATA / file).exists():
        pytest.skip(f"{DATA / file} is absent (set FRICTION_DATA)")
    write_bag(tmp_path / "bag", Table(DATA / file, load_map(signal_map)).messages(), {})
    assert_no_unit_is_suspected(tmp_path / "bag", tmp_path, vehicle, ("wheel_slip",))
