"""Friction samples against the truth of the plant, the three forms against each other, and bad input."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_curve_id.chapter.dead_reckoning import DeadReckonedSpeed
from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource, slip_equation
from friction_curve_id.interface import Refusal, Sample
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle_file import load_vehicle

WHEEL = load_vehicle("chapter_corner").corner("front_left")
INTERVAL = 0.005
Brake = Callable[..., Any]


def points(samples: list[Sample] | tuple[Sample, ...], source: FrictionSource) -> list[FrictionPoint]:
    maker = FrictionSamples(WHEEL, source)
    answers = [maker.update(sample) for sample in samples]
    return [answer for answer in answers if isinstance(answer, FrictionPoint)]


@pytest.mark.parametrize("source", FrictionSource)
@pytest.mark.parametrize("name", TABLE_8_1)
def test_every_source_gives_the_true_curve_without_noise(clean: Brake, name: str, source: FrictionSource) -> None:
    made = points(list(clean(name).samples), source)
    assert len(made) == 99
    slips, frictions = np.array([(point.slip, point.mu) for point in made]).T
    assert np.max(np.abs(frictions - burckhardt.friction(surface(name), slips))) < 0.012
    assert np.median(np.abs(frictions - burckhardt.friction(surface(name), slips))) < 0.001


@given(st.floats(0.0, 0.9), st.floats(1.0, 150.0), st.floats(0.0, 2000.0), st.floats(0.0, 1.3))
def test_8_8_is_the_inverse_of_8_7(slip: float, wheel_speed: float, torque: float, friction: float) -> None:
    w = WHEEL
    speed = wheel_speed * w.radius / (1.0 - slip)
    force = w.vertical_load * friction
    rate = -((1.0 - slip) / w.mass + w.radius**2 / w.inertia) * force / speed + w.radius * torque / (speed * w.inertia)
    assert slip_equation(w, slip, rate, wheel_speed, torque) == pytest.approx(friction, abs=1e-9)


@pytest.mark.parametrize(
    ("source", "least", "most"),
    [
        (FrictionSource.SLIP_EQUATION, 0.3, 1.5),
        (FrictionSource.WHEEL_EQUATION, 0.02, 0.05),
        (FrictionSource.DEAD_RECKONED, 0.02, 0.05),
    ],
)
def test_noise_on_friction_is_what_the_source_documents(
    clean: Brake, noisy: Brake, source: FrictionSource, least: float, most: float
) -> None:
    truth = {point.time: point.mu for point in points(list(clean("dry").samples), FrictionSource.WHEEL_EQUATION)}
    made = points(list(noisy("dry", seed=11).samples), source)
    spread = np.std([point.mu - truth[point.time] for point in made])
    assert least < spread < most


def test_dead_reckoned_slip_scatters_fifteen_times_less_than_measured_slip(clean: Brake, noisy: Brake) -> None:
    truth = clean("wet")
    middles = 0.5 * (truth.slip[1:] + truth.slip[:-1])
    errors = {}
    for source in (FrictionSource.WHEEL_EQUATION, FrictionSource.DEAD_RECKONED):
        made = points(list(noisy("wet", seed=3).samples), source)
        error = np.array([point.slip - middle for point, middle in zip(made, middles, strict=True)])
        errors[source] = float(np.std(np.diff(error)))
        assert abs(np.mean(error)) < 0.004
    assert 15.0 * errors[FrictionSource.DEAD_RECKONED] < errors[FrictionSource.WHEEL_EQUATION]


def test_dead_reckoning_conserves_momentum_of_vehicle_and_wheel() -> None:
    """m v + (J / r) omega falls by the impulse of the brake, whatever the tyre does in between."""
    reckoned = DeadReckonedSpeed(WHEEL)
    assert reckoned.start(100.0, None, 0.0) == pytest.approx(30.0)
    speed = reckoned.advance(0.1, -20.0, 500.0, 80.0, None)
    before = WHEEL.mass * 30.0 + WHEEL.inertia / WHEEL.radius * 100.0
    after = WHEEL.mass * speed + WHEEL.inertia / WHEEL.radius * 80.0
    assert before - after == pytest.approx(500.0 * 0.1 / WHEEL.radius)


def test_speed_without_measurement_waits_for_a_wheel_that_rolls_freely() -> None:
    maker = FrictionSamples(WHEEL)
    braked = maker.update(Sample(0.0, 100.0, None, 300.0))
    assert isinstance(braked, Refusal)
    assert braked.reason is Reason.NO_SLIP
    maker.update(Sample(0.005, 100.0, None, 0.0))
    assert isinstance(maker.update(Sample(0.010, 100.0, None, 0.0)), FrictionPoint)


def test_a_wheel_just_released_does_not_count_as_rolling_freely() -> None:
    reckoned = DeadReckonedSpeed(WHEEL)
    reckoned.start(100.0, None, 0.0)
    reckoned.advance(0.005, -40.0, 500.0, 60.0, None)
    after_release = reckoned.advance(0.005, 2.0, 0.0, 62.0, None)
    assert after_release > 29.0
    for _ in range(200):
        after_release = reckoned.advance(0.005, 0.0, 0.0, 62.0, None)
    assert after_release == pytest.approx(62.0 * WHEEL.radius, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"wheel_speed": math.nan}, Reason.BAD_INPUT),
        ({"brake_torque": math.inf}, Reason.BAD_INPUT),
        ({"brake_torque": None}, Reason.NO_PRESSURE),
        ({"vehicle_speed": math.nan}, Reason.BAD_INPUT),
        ({"vehicle_speed": 0.0}, Reason.LOW_SPEED),
        ({"vehicle_speed": -5.0}, Reason.LOW_SPEED),
        ({"vehicle_speed": 10.0}, Reason.NO_SLIP),
        ({"wheel_speed": 0.0}, Reason.LOW_SPEED),
        ({"wheel_speed": 1e9}, Reason.BAD_INPUT),
        ({"brake_torque": 1e9}, Reason.BAD_INPUT),
        ({"time": 49 * INTERVAL}, Reason.BAD_INPUT),
    ],
)
@pytest.mark.parametrize("source", FrictionSource)
def test_a_bad_sample_is_refused_and_leaves_the_state_as_it_was(
    clean: Brake, change: dict[str, float], reason: Reason, source: FrictionSource
) -> None:
    samples = clean("dry").samples
    disturbed, calm = FrictionSamples(WHEEL, source), FrictionSamples(WHEEL, source)
    for sample in samples[:50]:
        disturbed.update(sample)
        calm.update(sample)
    refusal = disturbed.update(samples[50]._replace(**({"time": samples[50].time - 0.5 * INTERVAL} | change)))
    assert isinstance(refusal, Refusal)
    assert refusal.reason is reason
    assert refusal.text
    assert disturbed.update(samples[50]) == calm.update(samples[50])


def test_missing_speed_is_refused_where_the_source_needs_it() -> None:
    answer = FrictionSamples(WHEEL, FrictionSource.WHEEL_EQUATION).update(Sample(0.0, 100.0, None, 0.0))
    assert isinstance(answer, Refusal)
    assert answer.reason is Reason.NO_SLIP


def test_no_point_bridges_a_gap_and_the_next_one_says_so(clean: Brake) -> None:
    samples = list(clean("dry").samples)
    maker = FrictionSamples(WHEEL)
    answers = [maker.update(sample) for sample in samples[:40] + samples[60:]]
    after = [answer for answer in answers[40:] if isinstance(answer, FrictionPoint)]
    assert after[0].after_gap
    assert not any(point.after_gap for point in after[1:])
    assert after[0].time - samples[59].time >= 2 * INTERVAL
