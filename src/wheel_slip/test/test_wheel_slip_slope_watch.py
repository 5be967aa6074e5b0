"""A grade step is distinguished from locking or steadily slipping wheels."""

from collections.abc import Callable
from math import nan

import pytest

from wheel_slip.slope_watch import SlopeWatch
from wheel_slip.tuning import SlopeTuning

MS = 1_000_000


def followed(
    difference: Callable[[int], float], acceleration: float = 0.0, alike: bool = True, slip: float = nan
) -> list[float]:
    """Mismatch over two seconds at 200 Hz; `difference` is that of all four wheels after a number of samples."""
    watch = SlopeWatch(SlopeTuning())
    found = []
    for k in range(400):
        watch.update((k + 1) * 5 * MS, alike, [difference(k)] * 4, acceleration, slip)
        found.append(watch.mismatch)
    return found


@pytest.mark.parametrize("slope", [-1.0, 0.6, 1.2])
def test_a_difference_that_a_road_can_make_is_told_once_it_has_lasted(slope: float) -> None:
    found = followed(lambda k: slope if k >= 100 else 0.0)
    assert not any(found[:140])
    assert all(each == slope for each in found[145:])


@pytest.mark.parametrize(
    ("difference", "acceleration"),
    [
        (lambda k: -0.02 * (k - 100) if k > 100 else 0.0, 0.0),  # slower and slower: a dive passes in 0.3 s
        (lambda k: 0.5, -6.0),  # steady slip of 8 %
        (lambda k: 0.3, 0.0),  # noise
        (lambda k: -8.0, 0.0),
    ],
)
def test_dives_steady_slip_and_noise_are_no_slope(difference: Callable[[int], float], acceleration: float) -> None:
    found = followed(difference, acceleration)
    assert sum(map(bool, found)) <= 20


@pytest.mark.parametrize("slip", [0.12, 0.14])
def test_a_wheel_that_keeps_its_slip_loses_less_than_its_car_by_that_slip(slip: float) -> None:
    """As under a slip control: a wheel at 12 % on wet loses 0.9 m/s^2 less than its car."""
    assert not any(followed(lambda _: slip * 7.8, -7.8, slip=slip))


def test_wheels_that_lose_more_than_they_can_by_their_slip_or_too_little_for_it_show_a_slope() -> None:
    assert any(followed(lambda _: -1.2, -7.8, slip=0.12))
    assert any(followed(lambda _: 1.4, -7.8, slip=0.05))
    assert any(followed(lambda _: 1.4, 7.8, slip=0.12)), "driven wheels that are slower than their car do not spin"


def test_wheels_that_do_not_turn_alike_say_nothing_for_half_a_second() -> None:
    assert not any(followed(lambda k: 1.0, alike=False))
    watch = SlopeWatch(SlopeTuning())
    watch.update(5 * MS, False, [1.0], 0.0, nan)
    found = []
    for k in range(1, 300):
        watch.update((k + 1) * 5 * MS, True, [1.0], 0.0, nan)
        found.append(watch.mismatch)
    assert found.index(1.0) == pytest.approx(140, abs=5)


def test_a_wheel_without_speed_is_no_sample() -> None:
    watch = SlopeWatch(SlopeTuning())
    watch.update(5 * MS, True, [], 0.0, nan)
    assert watch.mismatch == 0.0
