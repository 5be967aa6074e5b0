"""The comparison of two checkouts: tiny bags that differ in a known way, and checkouts that are scripts."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionSlope, WheelSlip
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from std_msgs.msg import Header

from benchmarks.__main__ import main
from benchmarks.checkouts.bag_differences import TopicDifference, bag_differences
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_runtime.stamps import from_nanoseconds

SLIP, SLOPE = "/front_left/slip", "/front_left/friction_slope"
STAMPS = (10**9, 10**9 + 5_000_000)


def slip(stamp: int, **changes: Any) -> WheelSlip:
    header = Header(stamp=from_nanoseconds(stamp), frame_id="front_left")
    given = {"slip": 0.1, "slip_rate": nan, "vehicle_speed": 30.0, "speed_source": 1, "valid": True} | changes
    return WheelSlip(header=header, wheel="front_left", **given)


def write(bag: Path, messages: Mapping[str, Sequence[Any]]) -> Path:
    with BagWriter(bag) as writer:
        for topic, given in messages.items():
            for number, message in enumerate(given):
                writer.write(writer.add_topic(installed_topic(topic, type(message))), 10**9 + number, encode(message))
    return bag


@pytest.fixture
def compared(tmp_path: Path) -> Callable[..., TopicDifference]:
    def compare(after: Sequence[WheelSlip], before: Sequence[WheelSlip] | None = None) -> TopicDifference:
        old = write(tmp_path / "before", {SLIP: before or [slip(stamp) for stamp in STAMPS]})
        return bag_differences(old, write(tmp_path / "after", {SLIP: after}))["slip"]

    return compare


def test_equal_messages_are_equal_to_the_last_bit_with_nan_equal_to_nan(
    compared: Callable[..., TopicDifference],
) -> None:
    found = compared([slip(stamp) for stamp in STAMPS])
    assert (found.before, found.after, found.same_bits) == (2, 2, 2)
    assert found.largest == 0.0
    assert found.row()["passed"]


def test_a_float_beyond_the_tolerance_is_named_with_its_difference(compared: Callable[..., TopicDifference]) -> None:
    found = compared([slip(STAMPS[0]), slip(STAMPS[1], slip=0.1 + 2e-9)])
    assert found.same_bits == 1
    assert found.fields == {"slip": 1}
    assert found.largest == pytest.approx(2e-9, rel=1e-6)
    assert found.largest_in == "slip"
    assert not found.row()["passed"]


def test_a_last_bit_is_seen_but_does_not_count(compared: Callable[..., TopicDifference]) -> None:
    found = compared([slip(STAMPS[0]), slip(STAMPS[1], vehicle_speed=30.0 * (1.0 + 2e-16), slip_variance=-0.0)])
    assert found.same_bits == 1
    assert 0.0 < found.largest < 1e-15
    assert found.row()["passed"]


def test_large_floats_are_judged_by_their_relative_difference(compared: Callable[..., TopicDifference]) -> None:
    before = [slip(STAMPS[0], vehicle_speed=1e6)]
    assert compared([slip(STAMPS[0], vehicle_speed=1e6 + 5e-4)], before).row()["passed"]


@pytest.mark.parametrize(
    "change",
    [{"slip_rate": 0.0}, {"slip": nan}, {"slip": float("inf")}, {"valid": False}, {"speed_source": 2}],
    ids=str,
)
def test_nan_beside_a_number_and_other_flags_and_enums_count(
    compared: Callable[..., TopicDifference], change: dict[str, Any]
) -> None:
    found = compared([slip(STAMPS[0], **change), slip(STAMPS[1])])
    assert found.fields == dict.fromkeys(change, 1)
    assert not found.row()["passed"]


def test_texts_are_listed_and_do_not_count(compared: Callable[..., TopicDifference]) -> None:
    found = compared([slip(STAMPS[0], reason_text="other words"), slip(STAMPS[1])])
    assert found.texts == {"reason_text": 1}
    assert found.same_bits == 1
    assert found.row()["passed"]


def test_messages_without_a_stamp_of_their_own_kind_are_unpaired(compared: Callable[..., TopicDifference]) -> None:
    found = compared([slip(STAMPS[0]), slip(STAMPS[1] + 1)])
    assert found.unpaired == 2
    assert found.same_bits == 1
    assert not found.row()["passed"]


def test_messages_of_one_stamp_are_paired_in_their_order(compared: Callable[..., TopicDifference]) -> None:
    before = [slip(STAMPS[0]), slip(STAMPS[0], slip=0.2)]
    found = compared([slip(STAMPS[0]), slip(STAMPS[0], slip=0.3)], before)
    assert (found.same_bits, found.unpaired) == (1, 0)
    assert found.largest == pytest.approx(0.1)


def test_a_missing_topic_is_named_and_one_without_messages_is_missing(tmp_path: Path) -> None:
    before = write(tmp_path / "before", {SLIP: [slip(STAMPS[0])], SLOPE: [FrictionSlope()]})
    after = write(tmp_path / "after", {SLIP: [slip(STAMPS[0])], SLOPE: []})
    found = bag_differences(before, after)
    assert found["friction_slope"].missing == [f"{SLOPE} (only before)"]
    assert not found["friction_slope"].row()["passed"]
    assert found["slip"].row()["passed"]


def write_own_type(bag: Path, definition: str, *values: Any) -> Path:
    """Write a bag with one message of a type that is installed nowhere."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, "some_msgs/msg/Slip"))
    kind: Any = store.types["some_msgs/msg/Slip"]
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/slip", kind.__msgtype__, typestore=store)
        writer.write(topic, 10**9, store.serialize_cdr(kind(*values), kind.__msgtype__))
    return bag


def test_definitions_may_differ_and_what_only_one_has_is_listed(tmp_path: Path) -> None:
    before = write_own_type(tmp_path / "before", "float64 slip\nuint8 old", 0.1, 1)
    after = write_own_type(tmp_path / "after", "float64[] more\nfloat64 slip\nuint8 new", np.zeros(2), 0.1, 1)
    found = bag_differences(before, after)["slip"]
    assert found.in_one == {"old (only before)", "new (only after)", "more (only after)"}
    assert found.same_bits == 1
    assert found.row()["passed"]


def test_a_sequence_of_another_length_counts(tmp_path: Path) -> None:
    bags = [write_own_type(tmp_path / str(count), "float64[] theta", np.zeros(count)) for count in (2, 3)]
    assert bag_differences(*bags)["slip"].fields == {"theta": 1}


def checkout(directory: Path, slip_of: float | None, script: str = "") -> Path:
    """Make a checkout whose `process` always writes the same estimate, or none."""
    estimates = [] if slip_of is None else [slip(STAMPS[0], slip=slip_of)]
    write(directory / "estimates", {SLIP: estimates})
    write(directory / "bags" / "dry", {SLIP: [slip(STAMPS[0])]})
    run = directory / "tools" / "run.bash"
    run.parent.mkdir()
    # python -m friction_bags process BAG --out OUT ...
    run.write_text(f'#!/usr/bin/env bash\n{script}\n[[ $4 = process ]] && cp -r "$(dirname "$0")/../estimates" "$7"\n')
    run.chmod(0o755)
    return directory


@pytest.mark.parametrize(("slip_after", "code"), [(0.1, 0), (0.2, 1)])
def test_exit_code_and_rows_show_whether_two_checkouts_agree(tmp_path: Path, slip_after: float, code: int) -> None:
    before, after = checkout(tmp_path / "before", 0.1), checkout(tmp_path / "after", slip_after)
    file = tmp_path / "rows.json"
    arguments = ["checkouts", "--before", str(before), "--after", str(after), "--json", str(file)]
    assert main(arguments) == code
    (row,) = json.loads(file.read_text())["rows"]
    assert (row["bag"], row["topic"], row["messages_before"]) == ("dry", "slip", 1)
    assert (row["value"], row["limit"], row["passed"]) == (code, 0, code == 0)
    assert row["fields_that_differ"] == ("slip (1)" if code else "")


def test_a_bag_without_estimates_has_a_row_too(tmp_path: Path) -> None:
    silent = [checkout(tmp_path / name, None) for name in ("before", "after")]
    file = tmp_path / "rows.json"
    assert main(["checkouts", "--before", str(silent[0]), "--after", str(silent[1]), "--json", str(file)]) == 0
    (row,) = json.loads(file.read_text())["rows"]
    assert (row["bag"], row["topic"], row["passed"]) == ("dry", "none", True)


def test_a_checkout_that_fails_or_is_none_ends_the_command_with_code_2_and_its_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = checkout(tmp_path / "good", 0.1)
    broken = checkout(tmp_path / "broken", 0.1, script="echo no such car >&2; exit 3")
    (tmp_path / "none" / "bags" / "dry").mkdir(parents=True)
    for after, said in ((broken, "no such car"), (tmp_path / "none", "no bags")):
        assert main(["checkouts", "--before", str(good), "--after", str(after)]) == 2
        assert said in capsys.readouterr().err
    assert main(["checkouts", "--before", str(tmp_path / "none"), "--after", str(good)]) == 2
    assert "is no checkout" in capsys.readouterr().err


def test_each_checkout_runs_without_what_another_put_into_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, after = (checkout(tmp_path / name, 0.1, 'echo "$PYTHONPATH" >> "$SEEN"') for name in ("before", "after"))
    monkeypatch.setenv("SEEN", str(tmp_path / "seen"))
    paths = [after / "install" / "lib", tmp_path / "outside", before / "src"]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, paths)))
    assert main(["checkouts", "--before", str(before), "--after", str(after)]) == 0
    assert (tmp_path / "seen").read_text().splitlines() == [str(tmp_path / "outside")] * 2


def test_both_are_given_the_parameter_files_and_the_supervisor_commands_by_default(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = (
        'while [[ $# -gt 0 ]]; do [[ $1 = --params-file ]] && echo "$(head -1 "$2")" >> "$SEEN"; shift; done; exit 1'
    )
    before = checkout(tmp_path / "before", 0.1, script)
    own = tmp_path / "own.yaml"
    own.write_text("/**/wheel_slip:\n  ros__parameters: {}\n")
    monkeypatch.setenv("SEEN", str(tmp_path / "seen"))
    assert main(["checkouts", "--before", str(before), "--after", str(before), "--params-file", str(own)]) == 2
    assert (tmp_path / "seen").read_text().splitlines() == ["/**/abs_supervisor:", "/**/wheel_slip:"]
