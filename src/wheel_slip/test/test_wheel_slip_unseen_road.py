"""Grade uncertainty of speed and bias, against random roads."""

import numpy as np
import pytest

from wheel_slip.speed_filter import AccelerometerParameters, SpeedFilter
from wheel_slip.tuning import SpeedFilterTuning
from wheel_slip.unseen_road import UnseenRoad

MS = 1_000_000
DT = 0.005


def test_stated_covariance_is_that_of_slopes_which_come_and_go_with_the_way() -> None:
    road, rng, length, deviation = UnseenRoad(0.0, 0.3, 5.0), np.random.default_rng(0), 5.0, 0.3
    speed, offset, travelled = 20.0, np.zeros(20_000), np.zeros(20_000)
    for _ in range(200):
        road.predict(DT, speed, sliding=True)
        stay = np.exp(-DT * speed / length)
        after = stay * offset + np.sqrt(1.0 - stay * stay) * deviation * rng.normal(size=offset.size)
        travelled -= 0.5 * DT * (offset + after)
        offset = after
        speed -= DT * 9.0
    drawn = np.cov(travelled, offset)
    assert road.total == pytest.approx((drawn[0, 0], drawn[0, 1], drawn[1, 1]), rel=0.04)


def test_a_car_that_stands_stays_on_its_slope() -> None:
    road = UnseenRoad(0.0, 0.3, 5.0)
    road.predict(1.0, 0.0, sliding=True)
    assert road.total == (0.0, 0.0, 0.0)


def test_a_slope_that_wheels_have_shown_does_not_go_with_the_way() -> None:
    road = UnseenRoad(0.06, 0.3, 5.0)
    road.doubt(1.0)
    for _ in range(200):
        road.predict(DT, 20.0, sliding=True)
    assert road.total[2] == pytest.approx(1.0 + 0.3**2, rel=1e-4)
    assert road.total[0] == pytest.approx(1.0, rel=0.1)


def test_a_speed_that_is_known_better_makes_the_slopes_that_led_to_it_less_likely() -> None:
    road = UnseenRoad(0.06, 0.3, 5.0)
    road.doubt(0.04)
    for _ in range(200):
        road.predict(DT, 20.0, sliding=True)
    before = road.total
    road.keep(0.25)
    assert road.total[0] == pytest.approx(0.25 * before[0])
    assert 0.3 * before[2] < road.total[2] < before[2]
    road.clear()
    assert road.total == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("slope", [-0.04, 0.04])
def test_a_step_of_the_slope_a_second_into_a_slide_is_within_two_deviations(slope: float) -> None:
    f = SpeedFilter(AccelerometerParameters(bias_stddev=1e-3), SpeedFilterTuning(gain_stddev=0.0), 0.0, 0.0, 0.0)
    f.predict(5 * MS, -9.0)
    f.start(22.0, 1e-4)
    speed = 22.0
    for k in range(2, 362):
        stepped = 9.81 * slope if k > 200 else 0.0
        f.predict(k * 5 * MS, -9.0 + stepped, observed=False, sliding=True)
        speed -= DT * 9.0
        assert abs(f.speed - speed) < 2.0 * f.speed_variance**0.5
