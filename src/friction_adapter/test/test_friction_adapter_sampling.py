from math import isnan

from friction_adapter.sampling import SampleGrouping

MS = 1_000_000


def front_and_rear() -> SampleGrouping:
    return SampleGrouping(("front", "rear"), 2, 5 * MS)


def test_an_instant_is_sent_with_its_last_source_at_the_stamp_of_its_first() -> None:
    instants = front_and_rear()
    assert instants.add("rear", 100 * MS, [(1, 20.0)]) == []
    assert instants.add("front", 101 * MS, [(0, 10.0)]) == [(100 * MS, [10.0, 20.0])]
    assert instants.incomplete == 0


def test_one_source_is_sent_at_once() -> None:
    assert SampleGrouping(("all",), 1, 0).add("all", 5, [(0, 1.0)]) == [(5, [1.0])]


def test_a_lost_source_leaves_its_values_out_and_never_those_of_another_instant() -> None:
    instants = front_and_rear()
    instants.add("front", 0, [(0, 10.0)])
    instants.add("rear", 0, [(1, 20.0)])
    assert instants.add("front", 10 * MS, [(0, 11.0)]) == []
    ((stamp, (front, rear)),) = instants.add("front", 20 * MS, [(0, 12.0)])
    assert (stamp, front) == (10 * MS, 11.0)
    assert isnan(rear)
    assert instants.add("rear", 20 * MS, [(1, 22.0)]) == [(20 * MS, [12.0, 22.0])]
    assert instants.incomplete == 1


def test_sources_further_apart_than_the_window_are_of_two_instants() -> None:
    instants = front_and_rear()
    instants.add("front", 0, [(0, 10.0)])
    ((stamp, (front, rear)),) = instants.add("rear", 6 * MS, [(1, 20.0)])
    assert (stamp, front) == (0, 10.0)
    assert isnan(rear)


def test_after_a_jump_back_in_time_an_instant_begins_anew() -> None:
    instants = front_and_rear()
    instants.add("front", 1000 * MS, [(0, 10.0)])
    assert len(instants.add("front", 0, [(0, 11.0)])) == 1
    assert instants.add("rear", 0, [(1, 21.0)]) == [(0, [11.0, 21.0])]


def test_a_reset_forgets_what_has_begun() -> None:
    instants = front_and_rear()
    instants.add("front", 0, [(0, 10.0)])
    instants.reset()
    assert instants.add("rear", 0, [(1, 20.0)]) == []
