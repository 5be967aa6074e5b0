"""Bags as arrays: what can be shown of a bag that holds tyres alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from friction_msgs.msg import FrictionSlope, Validity, WheelSlip

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.results.run_reader import read_run, require_samples

TYRES = Path(__file__).parents[3] / "bags" / "tyre_dynamic_2_0_bar"


def test_bag_of_tyres_alone_begins_with_its_first_message() -> None:
    run = read_run(TYRES, ("front_left", "rear_left"))
    forces = run.series["truth/rear_left/tyre_force"]
    assert run.samples.size == 0
    assert forces.time[0] == 0.0
    assert forces.time.size == 500


def test_bag_without_wheels_and_tyres_is_refused(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag", [("/front_left/friction_slope", FrictionSlope())], {})
    with BagReader(tmp_path / "bag") as reader, pytest.raises(BagError, match="no tyre signals"):
        require_samples(reader)


def test_reason_keeps_only_the_numbers_that_all_its_messages_have(tmp_path: Path) -> None:
    texts = ["speed 1.5 is below 2.0 m/s"] * 2 + ["slip is 0.1", "slip is 0.2", "slip is 0.3"]
    messages = [("/front_left/slip", WheelSlip(validity=Validity(text=text))) for text in texts]
    write_bag(tmp_path / "bag", messages, {})
    assert read_run(tmp_path / "bag").series["front_left/slip"].reasons == {
        "speed 1.5 is below 2.0 m/s": 2,
        "slip is …": 3,
    }
