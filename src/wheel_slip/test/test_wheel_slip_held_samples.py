"""Speed sensor and brake pressures: by message time, and never waited for."""

from math import isnan, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import FluidPressure

from friction_runtime.messages import header_at
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.ros.held_samples import BrakePressures, HeldSamples

CAR = load_vehicle("compact_car")
STEP = 5_000_000
MS = 1_000_000
START = 1_000_000_000
DELAY = round(1e9 * CAR.brake_pressure_delay)


def message(k: int, torque: float, wheel: int = 0) -> tuple[str, FluidPressure]:
    each = CAR.wheels[wheel]
    at = header_at(START + k * STEP + DELAY, "base_link")
    return f"{each.name}/brake_pressure", FluidPressure(header=at, fluid_pressure=torque / each.brake_gain)


@pytest.fixture
def brakes() -> BrakePressures:
    return BrakePressures(CAR, oldest=0.1)


def test_torques_are_those_of_twenty_milliseconds_ago_whatever_the_order_of_arrival(brakes: BrakePressures) -> None:
    early = BrakePressures(CAR, oldest=0.1)
    for k in range(20):
        assert early.offer(*message(k, float(k))) is None
    for k in range(10):
        assert brakes.offer(*message(k, float(k))) is None
        found = brakes.torques(START + k * STEP, rewound=False)
        assert early.torques(START + k * STEP, rewound=False) == pytest.approx(found, nan_ok=True)
        if k >= 4:
            assert found[0] == pytest.approx(k - 4)
            assert all(isnan(each) for each in found[1:])


def test_without_any_pressure_nothing_is_said(brakes: BrakePressures) -> None:
    assert brakes.torques(START, rewound=False) == []


def test_a_pressure_that_is_silent_is_not_known_any_more(brakes: BrakePressures) -> None:
    brakes.offer(*message(0, 100.0))
    brakes.offer(*message(0, 200.0, wheel=1))
    brakes.offer(*message(30, 150.0, wheel=1))
    found = brakes.torques(START + 35 * STEP, rewound=False)
    assert isnan(found[0])
    assert found[1] == pytest.approx(150.0)


def test_garbage_is_refused_with_its_topic_and_changes_nothing(brakes: BrakePressures) -> None:
    brakes.offer(*message(0, 100.0))
    topic, bad = message(1, nan)
    refusal = brakes.offer(topic, bad)
    assert refusal is not None
    assert topic in refusal
    late = brakes.offer(*message(0, 300.0))
    assert late is not None
    assert topic in late
    assert brakes.torques(START + 5 * STEP, rewound=False)[0] == pytest.approx(100.0)


def test_after_a_jump_back_the_run_before_is_forgotten(brakes: BrakePressures) -> None:
    brakes.offer(*message(0, 100.0))
    brakes.torques(START + 5 * STEP, rewound=False)
    assert brakes.torques(START - 20_000_000_000, rewound=True) == []


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 3)), min_size=1, max_size=80))
def test_queue_gives_the_same_samples_to_the_same_outputs_however_the_streams_interleave(
    steps: list[tuple[bool, int]],
) -> None:
    """Two streams at 5 ms, either ahead of the other by at most 3 samples, with a hold of 20 ms."""

    def run(lead: list[int]) -> dict[int, list[int]]:
        queue: HeldSamples[int] = HeldSamples()
        offered, given_to = 0, {}
        for k, ahead in enumerate(lead, start=5):
            while offered < k + ahead:
                offered += 1
                assert queue.offer(offered * 5 * MS, offered) is None
            given_to[k] = [payload for _, payload in queue.due(k * 5 * MS, False)]
        return given_to

    in_step = run([0] * len(steps))
    apart = run([offset - 3 if late else offset for late, offset in steps])
    assert in_step == apart


def test_queue_refuses_repeats_and_zero_and_starts_again_after_a_jump_back() -> None:
    queue: HeldSamples[str] = HeldSamples()
    assert queue.offer(0, "zero") == "stamp is zero"
    assert queue.offer(1000 * MS, "old") is None
    assert queue.offer(1000 * MS, "again") == "stamp repeats"
    assert queue.offer(951 * MS, "late") == "late sample"
    assert queue.late == 1
    assert list(queue.due(1010 * MS, False)) == []
    assert queue.offer(100 * MS, "new") is None
    assert list(queue.due(130 * MS, True)) == [(100 * MS, "new")]
