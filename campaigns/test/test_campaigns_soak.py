"""The soak: what it counts, and a short cut of it over DDS, slow enough for a busy machine."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from benchmarks.runner import failures
from campaigns.dds import ProcessUse, use_of
from campaigns.soak.graph import Answers, Seen, SoakGraph, answers, together
from campaigns.soak.part import Lap, lost_rows, use_rows
from friction_bags.record_replay.flow_control import header_stamp
from friction_runtime.messages import from_nanoseconds

MILLISECOND = 1_000_000
USE = ProcessUse(rss=100_000_000, threads=12, descriptors=14)


def lap(ended: float, use: ProcessUse = USE, lost: int = 0) -> Lap:
    return Lap(ended, {"front_left/slip": Answers(100, lost, np.full(100 - lost, 2.0))}, {"wheel_slip": use}, 1.0)


def seen(published: dict[int, int]) -> Seen:
    found = Seen()
    for stamp, at in published.items():
        found.note(stamp, at)
    return found


def test_the_stamp_of_a_serialized_message_is_read_without_decoding_it() -> None:
    stamp = 1_700_000_000_123_456_789
    message = JointState(header=Header(stamp=from_nanoseconds(stamp), frame_id="x"), name=["a"], velocity=[1.0])
    assert header_stamp(serialize_message(message)) == stamp


def test_a_sample_without_answer_is_lost_and_a_heartbeat_of_the_lap_before_answers_none() -> None:
    sent = seen({stamp: stamp * MILLISECOND for stamp in (0, 5, 10, 15, 20)})
    topic = seen({15: 1, 5: 8 * MILLISECOND, 20: 3})
    topic.note(15, 20 * MILLISECOND)
    topic.note(15, 90 * MILLISECOND)
    found = answers(sent, topic, begin=5)
    assert (found.samples, found.lost) == (4, 2)
    assert sorted(found.delays) == [3.0, 5.0]
    assert together([found, found]).lost == 4


def test_what_a_process_holds_is_read_while_it_changes() -> None:
    before = use_of(os.getpid())
    opened = [os.open("/dev/null", os.O_RDONLY) for _ in range(5)]
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    after = use_of(os.getpid())
    done.set()
    thread.join()
    for descriptor in opened:
        os.close(descriptor)
    assert after.descriptors - before.descriptors == 5
    assert after.threads - before.threads == 1
    assert before.rss > 10e6


def test_memory_that_grows_after_the_warm_up_fails_and_before_it_does_not() -> None:
    def growing(rate: float) -> list[Lap]:
        return [lap(6.0 * k, ProcessUse(100_000_000 + round(rate * 6.0 * k), 12, 14)) for k in range(200)]

    assert [row["quantity"] for row in failures(use_rows(growing(3000.0)))] == ["growth of the memory [MB/h]"]
    assert not failures(use_rows(growing(1000.0)))
    warm = [lap(6.0 * k, ProcessUse(100_000_000 + min(k, 30) * 1_000_000, 12, 14)) for k in range(200)]
    assert not failures(use_rows(warm))


@pytest.mark.parametrize(
    ("use", "named"),
    [
        (ProcessUse(100_000_000, 13, 14), "change of the threads"),
        (ProcessUse(100_000_000, 12, 15), "change of the descriptors"),
    ],
)
def test_a_thread_or_a_descriptor_more_fails_in_the_shortest_run(use: ProcessUse, named: str) -> None:
    laps = [lap(6.0), lap(12.0), lap(18.0, use)]
    assert [row["quantity"] for row in failures(use_rows(laps))] == [named]


def test_lost_samples_fail() -> None:
    assert failures(lost_rows([lap(6.0), lap(12.0, lost=1)]))
    assert not failures(lost_rows([lap(6.0), lap(12.0)]))


def test_the_graph_answers_every_sample_of_its_laps_and_keeps_its_threads_and_descriptors() -> None:
    with SoakGraph(lap=1.5, pace=0.25) as graph:
        laps = [Lap(float(k), graph.lap(), graph.use(), 1.0) for k in range(3)]
        assert graph.patches > 0
    assert {"front_left/slip", "front_left/friction_curve", "front_left/brake_command"} <= laps[0].answers.keys()
    assert all(row["samples"] > 250 for row in lost_rows(laps))
    assert not failures(lost_rows(laps))
    assert {"corner_sim", "abs_supervisor", "smart_tyre_forces"} <= laps[0].uses.keys()
    assert not failures(use_rows(laps))
