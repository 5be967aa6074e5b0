"""Input alignment: interpolation, deadlines, epochs, and independence of the order of arrival."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_runtime.aligner import AlignedInput, AlignedSample, Aligner

MS = 1_000_000
START = 1_000 * MS


def aligner(deadline: float = 0.05, max_gap: float = 0.1) -> Aligner[float]:
    return Aligner("wheel_states", [AlignedInput("pressure", max_gap), AlignedInput("imu", max_gap)], deadline)


def feed(target: Aligner[float], events: list[tuple[str, int]]) -> list[AlignedSample[float]]:
    """Offer (topic, stamp in ms after START); the value of an input is its stamp, so that interpolation shows."""
    out: list[AlignedSample[float]] = []
    for topic, at in events:
        stamp = START + at * MS
        if topic == "wheel_states":
            target.offer_primary(stamp, float(at))
        else:
            target.offer(topic, stamp, (float(at),))
        out.extend(target.ready())
    return out


def test_sample_waits_until_every_input_has_passed_its_stamp() -> None:
    a = aligner()
    assert feed(a, [("pressure", 0), ("imu", 0), ("wheel_states", 5), ("pressure", 10)]) == []
    (sample,) = feed(a, [("imu", 7)])
    assert sample.values["pressure"] == (5.0,)
    assert sample.values["imu"] == (5.0,)
    assert not sample.missing


def test_sample_with_the_same_stamp_is_taken_as_it_is() -> None:
    (sample,) = feed(aligner(), [("pressure", 5), ("imu", 5), ("wheel_states", 5)])
    assert sample.values == {"pressure": (5.0,), "imu": (5.0,)}


def test_input_that_never_comes_is_missing_after_the_deadline_and_named() -> None:
    a = aligner(deadline=0.02)
    events = [(topic, t) for t in range(0, 30, 5) for topic in ("wheel_states", "imu")]
    samples = feed(a, events)
    assert [s.payload for s in samples] == [0.0, 5.0]
    assert samples[0].missing == {"pressure": "pressure: no sample received"}
    assert samples[0].values == {"imu": (0.0,)}


def test_input_that_falls_silent_is_missing_with_its_age() -> None:
    a = aligner(deadline=0.02)
    feed(a, [("pressure", 0), ("imu", 0), ("wheel_states", 0)])
    samples = feed(a, [(topic, t) for t in range(5, 60, 5) for topic in ("wheel_states", "imu")])
    assert "pressure: silent, last sample 0.005 s older" in samples[0].missing.values()


def test_values_are_not_interpolated_across_a_gap() -> None:
    a = aligner(deadline=1.0, max_gap=0.1)
    (sample,) = feed(a, [("pressure", 0), ("imu", 50), ("wheel_states", 50), ("pressure", 150)])
    assert sample.missing == {"pressure": "pressure: gap around this stamp"}


def test_zero_repeated_and_not_finite_samples_are_refused_by_name_and_change_nothing() -> None:
    a = aligner()
    feed(a, [("pressure", 0), ("wheel_states", 0)])
    assert a.offer("pressure", START, (1.0,)) == "pressure: stamp repeats"
    assert a.offer("pressure", 0, (1.0,)) == "pressure: stamp is zero"
    assert a.offer("pressure", START + MS, (math.nan,)) == "pressure: value is not finite"
    assert a.offer_primary(START, 9.0) == "wheel_states: stamp repeats"
    (sample,) = feed(a, [("imu", 0)])
    assert sample.values["pressure"] == (0.0,)


def test_jump_back_marks_the_first_sample_and_mixes_nothing_from_before() -> None:
    a = aligner()
    grid = [(topic, t) for t in range(0, 60, 5) for topic in ("pressure", "imu", "wheel_states")]
    first, second = feed(a, grid), feed(a, grid)
    assert [s.rewound for s in first + second] == [False] * 12 + [True] + [False] * 11
    assert [s.values for s in second] == [s.values for s in first]


def test_input_whose_clock_jumps_alone_is_used_again_after_the_deadline() -> None:
    a = aligner(deadline=0.02)
    feed(a, [(topic, t) for t in range(0, 60, 5) for topic in ("pressure", "imu", "wheel_states")])
    feed(a, [("imu", 1)])
    samples = feed(a, [(topic, t) for t in range(60, 120, 5) for topic in ("pressure", "imu", "wheel_states")])
    assert samples[0].missing
    assert not samples[-1].missing


def test_input_that_does_not_follow_a_jump_back_is_used_again_after_the_deadline() -> None:
    a = aligner(deadline=0.02)
    feed(a, [(topic, t) for t in range(100, 140, 5) for topic in ("pressure", "imu", "wheel_states")])
    samples = feed(a, [(topic, t) for t in range(0, 40, 5) for topic in ("pressure", "wheel_states")])
    assert [set(s.missing) for s in samples] == [{"imu"}] * len(samples)
    samples = feed(a, [(topic, t) for t in range(40, 120, 5) for topic in ("pressure", "imu", "wheel_states")])
    assert not samples[-1].missing


@pytest.mark.parametrize(("back", "new_run"), [(7, False), (49, False), (50, True)])
def test_a_stamp_that_steps_back_by_less_than_50_ms_is_late_and_begins_no_new_run(back: int, new_run: bool) -> None:
    a = aligner()
    feed(a, [(topic, t) for t in range(0, 105, 5) for topic in ("pressure", "imu", "wheel_states")])
    late = START + (100 - back) * MS
    expected = None if new_run else f"{{}}: late sample, {back / 1000:.4f} s before the newest"
    for topic in ("pressure", "imu"):
        assert a.offer(topic, late, (9.0,)) == (expected and expected.format(topic))
    assert a.offer_primary(late, 9.0) == (expected and expected.format("wheel_states"))
    assert a.late() == ({} if new_run else {"wheel_states": 1, "pressure": 1, "imu": 1})
    assert [sample.rewound for sample in a.ready()] == ([True] if new_run else [])
    a.reset()
    assert a.late() == {}


@given(st.sets(st.integers(1, 38)), st.integers(1, 9))
def test_late_samples_leave_the_others_as_they_would_be_without_them(late: set[int], by: int) -> None:
    straight: list[tuple[str, int]] = []
    disturbed: list[tuple[str, int]] = []
    for k in range(40):
        for topic in ("pressure", "imu", "wheel_states"):
            if k not in late:
                straight.append((topic, 5 * k))
                disturbed.append((topic, 5 * k))
                if k - 1 in late:  # it comes after the next one
                    disturbed.append((topic, 5 * k - by))
    taken = [
        [(s.stamp, s.values, s.missing, s.rewound) for s in feed(aligner(), events)] for events in (straight, disturbed)
    ]
    assert taken[0] == taken[1]


def answer_delays(events: list[tuple[str, int]], deadline: float, max_gap: float) -> dict[int, int]:
    """Message time [ms] that had passed when each primary sample came out."""
    a = aligner(deadline, max_gap)
    delays = {}
    for topic, at in events:
        for sample in feed(a, [(topic, at)]):
            delays[(sample.stamp - START) // MS] = at - (sample.stamp - START) // MS
    return delays


def test_an_input_that_is_silent_for_longer_than_its_gap_is_not_waited_for_until_it_is_back() -> None:
    others = ("imu", "wheel_states")
    before = [(topic, t) for t in range(0, 100, 5) for topic in ("pressure", *others)]
    silent = [(topic, t) for t in range(100, 300, 5) for topic in others]
    back = [(topic, t) for t in range(300, 400, 5) for topic in ("wheel_states", "imu", "pressure")]
    delays = answer_delays(before + silent + back, deadline=0.03, max_gap=0.03)
    assert all(delays[t] == 0 for t in (*range(0, 100, 5), *range(160, 395, 5)))
    assert max(delays.values()) == 30
    samples = {s.payload: s for s in feed(aligner(0.03, 0.03), before + silent + back)}
    for t in range(100, 305, 5):
        age = (t - 95) / 1000
        assert samples[t].missing == {"pressure": f"pressure: silent, last sample {age:.3f} s older"}
    assert all(not samples[t].missing for t in (*range(0, 100, 5), *range(310, 395, 5)))


@given(st.data())
def test_around_a_silence_values_do_not_depend_on_which_stream_arrives_first(data: st.DataObject) -> None:
    begin, end = data.draw(st.integers(2, 20)), data.draw(st.integers(31, 60))
    stamps = {topic: [5 * k for k in range(80) if topic != "pressure" or not begin <= k < end]
              for topic in ("wheel_states", "pressure", "imu")}  # fmt: skip
    orders = []
    for _ in range(2):
        lag = {topic: data.draw(st.integers(0, 29)) for topic in stamps}
        events = sorted((at + lag[topic], topic, at) for topic, own in stamps.items() for at in own)
        samples = feed(aligner(0.031, 0.03), [(topic, at) for _, topic, at in events])
        back = START + (5 * end + 30) * MS  # the streams are up to 29 ms apart
        orders.append([(s.stamp, s.values) for s in samples if s.stamp < START + 5 * end * MS or s.stamp >= back])
    shorter = min(map(len, orders))
    assert shorter > 35
    assert orders[0][:shorter] == orders[1][:shorter]


def test_an_input_that_has_never_come_is_waited_for_until_the_deadline() -> None:
    events = [(topic, t) for t in range(0, 200, 5) for topic in ("imu", "wheel_states")]
    assert set(answer_delays(events, deadline=0.03, max_gap=0.03).values()) == {30}


def test_reset_forgets_everything() -> None:
    a = aligner()
    feed(a, [("pressure", 0), ("imu", 0), ("wheel_states", 0), ("wheel_states", 5)])
    a.reset()
    (sample,) = feed(a, [("pressure", 0), ("imu", 0), ("wheel_states", 0)])
    assert not sample.rewound


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_output_does_not_depend_on_the_order_of_arrival_across_topics(data: st.DataObject) -> None:
    stamps = st.lists(st.integers(0, 200), min_size=2, max_size=25, unique=True).map(sorted)
    loops = [{topic: data.draw(stamps) for topic in ("wheel_states", "pressure", "imu")} for _ in range(2)]
    streams: dict[str, list[int]] = {topic: [] for topic in loops[0]}
    for loop in loops:
        for topic, own in loop.items():
            # Every stream goes back at the loop, and ends at or past the primary, so that nothing waits for ever.
            streams[topic].extend([-1, *own, 201] if topic != "wheel_states" else own)
    step_back = loops[0]["wheel_states"][-1] - loops[1]["wheel_states"][0]
    if step_back < 50:  # no new run: late samples, while the inputs, which end at 201, do begin one
        return
    orders = []
    for _ in range(2):
        left = {topic: list(own) for topic, own in streams.items()}
        events = []
        while any(left.values()):
            topic = data.draw(st.sampled_from(sorted(t for t, own in left.items() if own)))
            events.append((topic, left[topic].pop(0)))
        samples = feed(aligner(deadline=1e6, max_gap=1.0), events)  # no stream is ever silent
        orders.append([(s.stamp, s.payload, s.values, s.missing, s.rewound) for s in samples])
    assert orders[0] == orders[1]
    assert len(orders[0]) == len(streams["wheel_states"])


def with_optional() -> Aligner[float]:
    return Aligner("wheel_states", [AlignedInput("curve", max_gap=0.02, optional=True)], deadline=0.05)


def test_optional_input_is_not_waited_for_before_it_comes_regularly() -> None:
    a = with_optional()
    (sample,) = feed(a, [("wheel_states", 0)])
    assert sample.missing == {"curve": "curve: no sample received"}
    assert len(feed(a, [("curve", 5), ("wheel_states", 10)])) == 1
    # samples further apart than its gap: nobody knows when the next one comes
    assert len(feed(a, [("curve", 60), ("wheel_states", 65)])) == 1


def test_optional_input_that_comes_regularly_is_waited_for_as_any_other() -> None:
    a = with_optional()
    assert feed(a, [("curve", 0), ("curve", 5), ("wheel_states", 10)]) == []
    (sample,) = feed(a, [("curve", 10)])
    assert sample.values == {"curve": (10.0,)}
    assert [s.payload for s in feed(a, [("wheel_states", at) for at in (15, 35, 70)])] == [15.0, 35.0, 70.0]
