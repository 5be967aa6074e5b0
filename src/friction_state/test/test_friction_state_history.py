"""Messages by their stamps: newest at or before a stamp, jumps back, late messages."""

from friction_state.history import History

MS = 1_000_000


def test_newest_at_or_before_a_stamp_counts_within_the_timeout() -> None:
    history: History[str] = History()
    for stamp, item in ((10 * MS, "a"), (20 * MS, "b"), (30 * MS, "c")):
        history.put(stamp, item)
    assert history.at(5 * MS, 1.0) is None
    assert history.at(20 * MS, 0.0) == "b"
    assert history.at(25 * MS, 0.0) is None
    assert history.at(25 * MS, 0.005) == "b"
    assert history.at(40 * MS, 0.005) is None


def test_a_late_message_is_left_out_and_a_jump_back_forgets_what_was() -> None:
    history: History[str] = History()
    history.put(1000 * MS, "old")
    history.put(990 * MS, "late")
    assert history.at(1000 * MS, 0.0) == "old"
    history.put(10 * MS, "new run")
    assert history.at(1000 * MS, 0.5) is None
    assert history.at(10 * MS, 0.0) == "new run"
