"""Inputs of the safety monitor do not depend on the order of arrival."""

from math import isfinite

import pytest
from friction_msgs.msg import SlopeVote, Validity, WheelSlip

from abs_supervisor.ros.wheel_inputs import WheelInputs
from friction_runtime.aligner import AlignedSample
from friction_runtime.messages import header_at
from friction_runtime.processor import silent
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

WHEEL = "front_left"
STEP = 5_000_000


def test_a_vote_is_told_why_its_own_slip_is_not_valid_whatever_slip_came_last() -> None:
    inputs = WheelInputs(WHEEL, load_vehicle("chapter_corner"), silent, fine=False)
    for number, text in ((2, "too slow"), (3, "too slow"), (4, "no speed")):
        inputs.read(inputs.slip, WheelSlip(header=header_at(number * STEP, WHEEL), validity=Validity(text=text)))
    told = []
    for number in (1, 2, 3, 4, 5):
        sample = AlignedSample(number * STEP, 0.0, SlopeVote(), {}, {}, False)
        told.append(inputs.observe(sample, 0.0).slip_text)
    assert told == [f"{WHEEL}/slip: {text}" for text in ("not valid", "too slow", "too slow", "no speed", "no speed")]
    inputs.read(inputs.slip, WheelSlip(header=header_at(STEP, WHEEL), validity=Validity(text="a new run")))
    assert inputs.observe(AlignedSample(STEP, 0.0, SlopeVote(), {}, {}, False), 0.0).slip_text.endswith("a new run")


@pytest.mark.parametrize("share", [0.01, 0.9], ids=["locked", "nearly rolling"])
@pytest.mark.parametrize(
    ("speed", "stddev", "tells"), [(20.0, 6.0, True), (20.0, 7.0, False), (2.0, 1.4, True), (2.0, 1.6, False)]
)
def test_a_speed_of_the_car_counts_with_a_deviation_up_to_a_third_of_it_or_one_and_a_half_metres_a_second(
    speed: float, stddev: float, tells: bool, share: float
) -> None:
    vehicle = load_vehicle("chapter_corner")
    inputs = WheelInputs(WHEEL, vehicle, silent, fine=True)
    message = WheelSlip(header=header_at(STEP, WHEEL), validity=Validity(reason=Reason.UNCERTAIN), vehicle_speed=speed)
    message.vehicle_speed_stddev, message.wheel_speed = stddev, share * speed / vehicle.wheels[0].radius
    read = inputs.read(inputs.slip, message)
    assert not isinstance(read, str)
    sample = AlignedSample(STEP, 0.0, SlopeVote(), {inputs.slip: read[1]}, {}, False)
    seen = inputs.observe(sample, 0.0)
    assert (seen.car_speed == speed, isfinite(seen.slip)) == (tells, tells)
    assert not tells or seen.slip == pytest.approx(1.0 - share)


@pytest.mark.parametrize(("stddev", "known"), [(0.01, True), (2.0, False), (1e200, False)])
def test_a_valid_slip_with_a_deviation_beyond_any_slip_is_none(stddev: float, known: bool) -> None:
    vehicle = load_vehicle("chapter_corner")
    inputs = WheelInputs(WHEEL, vehicle, silent, fine=False)
    message = WheelSlip(header=header_at(STEP, WHEEL), validity=Validity(valid=True), slip=0.1, slip_stddev=stddev)
    message.vehicle_speed, message.wheel_speed = 20.0, 0.9 * 20.0 / vehicle.wheels[0].radius
    read = inputs.read(inputs.slip, message)
    assert not isinstance(read, str)
    seen = inputs.observe(AlignedSample(STEP, 0.0, SlopeVote(), {inputs.slip: read[1]}, {}, False), 0.0)
    assert isfinite(seen.slip) == known
