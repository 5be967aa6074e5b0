import time
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionCurve, TyreSignals, Validity, WheelSlip
from sensor_msgs.msg import FluidPressure, JointState

from benchmarks.runner import failures
from campaigns.__main__ import main
from campaigns.fuzz import part
from campaigns.fuzz.garbage import garbage, impossible, raw_garbage
from campaigns.fuzz.live import live_rows
from campaigns.fuzz.update_time import CORNER, wrong_unit_rows
from friction_bags.bag_io.cdr import encode


class Broken:
    """A processor that has every fault that is looked for."""

    def __init__(self) -> None:
        self.seen = 0

    def process(self, topic: str, message: FluidPressure) -> list[tuple[str, Any]]:
        self.seen += 1
        if not np.isfinite(message.fluid_pressure):
            raise OverflowError("too large")
        return [
            (
                "front_left/slip",
                WheelSlip(slip=message.fluid_pressure, slip_stddev=1.0, validity=Validity(valid=True)),
            )
        ]

    def reset(self) -> None:
        self.seen = max(self.seen, 0)


def test_garbage_can_be_sent_and_leaves_the_message_it_is_made_from_alone() -> None:
    rng = np.random.default_rng(0)
    states = JointState(name=["a", "b"], velocity=[1.0, 2.0])
    before = repr(states)
    different = 0
    for _ in range(200):
        broken = garbage(states, rng)
        encode(broken)
        different += repr(broken) != before
    assert repr(states) == before
    assert different > 150


def test_garbage_has_blocks_that_are_far_too_long_with_all_their_arrays_of_one_length() -> None:
    rng = np.random.default_rng(1)
    block = TyreSignals(encoder_voltage=[0.0] * 50, radial_acceleration=[0.0] * 50)
    lengths = {(len(b.encoder_voltage), len(b.radial_acceleration)) for b in (garbage(block, rng) for _ in range(8000))}
    assert (100_000, 100_000) in lengths


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (WheelSlip(slip=-11.7, slip_stddev=0.1, validity=Validity(valid=True)), "slip"),
        (WheelSlip(slip=float("nan"), slip_stddev=0.1, validity=Validity(valid=True)), "slip"),
        (FrictionCurve(lambda_max=0.1, mu_max=3.94, validity=Validity(valid=True)), "mu_max"),
        (FrictionCurve(lambda_max=float("nan"), probability_beyond_peak=1.2), "probability"),
    ],
)
def test_what_no_car_does_is_impossible(message: Any, said: str) -> None:
    assert said in impossible(message)


def test_invalid_answers_and_plausible_ones_are_not_impossible() -> None:
    assert not impossible(WheelSlip(slip=-11.7, validity=Validity(valid=False)))
    assert not impossible(WheelSlip(slip=0.2, slip_stddev=0.1, validity=Validity(valid=True)))
    assert not impossible(
        FrictionCurve(lambda_max=0.1, mu_max=1.1, probability_beyond_peak=float("nan"), validity=Validity(valid=True))
    )


def test_exceptions_impossible_estimates_and_updates_without_end_are_found() -> None:
    findings = part._Findings()
    processor = Broken()
    findings.feed(processor, "p", FluidPressure(fluid_pressure=float("inf")))
    findings.feed(processor, "p", FluidPressure(fluid_pressure=5.0))
    findings.feed(processor, "p", FluidPressure(fluid_pressure=0.1))
    assert len(findings.exceptions) == 1
    assert "too large" in findings.exceptions[0]
    assert len(findings.impossible) == 1
    with pytest.raises(part._TookTooLongError), part._no_longer_than(0.05):
        begun = time.process_time()
        while time.process_time() - begun < 60.0:
            pass


def test_every_processor_survives_hostile_messages(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fuzz", "--messages", "12000", "--seed", "7"]) == 0
    assert "friction_curve_id car" in capsys.readouterr().out


def test_an_unknown_processor_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fuzz", "--processors", "nobody"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_raw_garbage_is_another_sequence_of_bytes_each_time_and_may_be_empty() -> None:
    rng = np.random.default_rng(2)
    serialized = encode(JointState(name=["a"], velocity=[1.0]))
    found = [raw_garbage(serialized, rng) for _ in range(3000)]
    assert sum(each == serialized for each in found) < 30
    assert min(map(len, found)) == 0
    assert {each[:4] for each in found} != {serialized[:4]}


@pytest.mark.parametrize("node", ["wheel_slip", "friction_curve_id"])
def test_a_node_outlives_typed_garbage_and_raw_bytes_and_answers_a_clean_drive_again(node: str) -> None:
    rows = live_rows([node], 5.0, np.random.default_rng(3))
    assert not failures(rows)
    assert rows[0]["messages"] > 200


def test_wrong_units_are_named_on_stops_of_the_plant_and_right_ones_never() -> None:
    rows = wrong_unit_rows([CORNER], ["wet"])
    assert {row["processor"] for row in rows} == {"chapter_corner, gentle", "chapter_corner, hard"}
    assert len([row for row in rows if row["limit"] == 1]) == 11
    assert not failures(rows)
