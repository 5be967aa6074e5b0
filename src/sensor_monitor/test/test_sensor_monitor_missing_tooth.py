"""The gap of a ring that lacks teeth."""

from math import pi

from sensor_monitor.missing_tooth import MissingTooth

TEETH, MISSING = 60, 2
PITCH = 2.0 * pi / TEETH
STEP = 0.005
SPEED = 60.0
SAMPLES = round(2.0 * pi / (SPEED * STEP))
"""In a revolution."""
LOW = SPEED / 3.0
"""One edge where three pitches have passed."""


def held(gap: MissingTooth, speeds: list[float]) -> list[int]:
    """Return which samples are those of the gap, of a wheel that is expected to go on at SPEED."""
    return [k for k, speed in enumerate(speeds) if gap.holds(STEP, SPEED, speed, 0.1)]


def revolution(at: int) -> list[float]:
    """One revolution with the gap at a sample."""
    return [LOW if k == at else SPEED for k in range(SAMPLES)]


def test_a_speed_that_falls_once_in_a_revolution_is_that_of_the_gap() -> None:
    assert held(MissingTooth(MISSING, PITCH), 10 * revolution(3)) == [3 + k * SAMPLES for k in range(10)]


def test_a_wheel_that_dives_is_not_taken_for_the_gap_once_that_is_known() -> None:
    gap = MissingTooth(MISSING, PITCH)
    held(gap, 4 * revolution(3))
    dive = [LOW if k > 10 else SPEED for k in range(SAMPLES)]
    assert held(gap, dive) == []


def test_a_wheel_that_dives_before_the_gap_is_known_is_held_for_the_length_of_a_gap_at_most() -> None:
    dive = held(MissingTooth(MISSING, PITCH), [SPEED] * 5 + [LOW] * (SAMPLES // 2))
    assert len(dive) * STEP * SPEED < 0.2 * 2.0 * pi


def test_the_gap_is_found_again_at_another_angle_after_the_wheel_was_locked() -> None:
    gap = MissingTooth(MISSING, PITCH)
    held(gap, 4 * revolution(3))
    found = held(gap, 4 * [SPEED] * SAMPLES + 4 * revolution(12))
    assert found == [12 + k * SAMPLES for k in range(4, 8)]
