"""The chapter's methods as estimators: accuracy on manoeuvre B, start rule, restarts, refusals, hostile streams."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource
from friction_curve_id.chapter.start_parameters import StartParameters
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause, Sample
from friction_curve_id.methods import CHAPTER_METHODS, exact_wheel_estimator
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

Brake = Callable[..., Any]
INTERVAL = 0.005
WHEEL = load_vehicle("chapter_corner").corner("front_left")
NAMES = tuple(CHAPTER_METHODS)


@pytest.mark.parametrize(
    ("name", "surface_name", "largest_median"),
    [
        ("ml", "dry", 2.2),
        ("ml", "wet", 3.3),
        ("ml", "cobblestone", 0.6),
        ("rml", "dry", 3.5),
        ("rml", "wet", 5.0),
        ("rml", "cobblestone", 6.8),
        ("rml_ml", "dry", 3.5),
        ("rml_ml", "wet", 5.0),
        ("rml_ml", "cobblestone", 6.8),
        ("ls", "dry", 5.1),
        ("ls", "wet", 4.9),
        ("ls", "cobblestone", 1.6),
        ("rls", "dry", 5.1),
        ("rls", "wet", 4.9),
        ("rls", "cobblestone", 1.6),
    ],
)
def test_median_error_of_lambda_max_after_100_samples(
    noisy: Brake, name: str, surface_name: str, largest_median: float
) -> None:
    truth = float(burckhardt.peak(surface(surface_name))[0])
    errors = []
    for seed in range(80):
        samples, fit = FrictionSamples(WHEEL), CHAPTER_METHODS[name]()
        points = [samples.update(sample) for sample in noisy(surface_name, seed).samples]
        slips, frictions = np.array([(p.slip, p.mu) for p in points if isinstance(p, FrictionPoint)]).T
        assert len(slips) == 99
        fit.start(slips[:20], frictions[:20])
        for slip, friction in zip(slips[20:], frictions[20:], strict=True):
            fit.add(float(slip), float(friction))
        curve = fit.curve()
        error = abs(curve.model.peak(curve.parameters) / truth - 1.0) * 100.0
        errors.append(error if error < 50.0 else 100.0)
    assert np.median(errors) <= largest_median


@pytest.mark.parametrize("source", FrictionSource)
@pytest.mark.parametrize("name", NAMES)
def test_no_method_fails_in_silence_or_raises_on_the_noisiest_source(
    noisy: Brake, name: str, source: FrictionSource
) -> None:
    for surface_name in ("snow", "dry"):
        estimator = exact_wheel_estimator(name, WHEEL, source=source)
        for sample in noisy(surface_name, seed=5).samples:
            answer = estimator.update(sample)
            if isinstance(answer, CurveEstimate):
                assert answer.valid == (answer.reason is Reason.OK)
                assert not answer.valid or 0.0 < answer.lambda_max < 1.0
                assert answer.valid or answer.text


@pytest.mark.parametrize("name", NAMES)
def test_the_fit_begins_with_20_friction_samples(clean: Brake, name: str) -> None:
    estimator = exact_wheel_estimator(name, WHEEL)
    answers = [estimator.update(sample) for sample in clean("dry").samples]
    kinds = [isinstance(answer, CurveEstimate) for answer in answers]
    assert kinds.index(True) == 20
    assert all(kinds[20:])
    assert all(answer.reason is Reason.NOT_READY for answer in answers[:20])


@pytest.mark.parametrize("name", ["rls", "rml_ml"])
def test_the_fit_begins_beyond_lambda_init_as_in_tables_8_4_and_8_5(clean: Brake, name: str) -> None:
    braking = clean("dry")
    estimator = exact_wheel_estimator(name, WHEEL, start=StartParameters(lambda_init=0.07))
    answers = [estimator.update(sample) for sample in braking.samples]
    begun = [isinstance(answer, CurveEstimate) for answer in answers].index(True)
    middle = 0.5 * (braking.slip[begun] + braking.slip[begun - 1])
    before = 0.5 * (braking.slip[begun - 1] + braking.slip[begun - 2])
    assert before < 0.071
    assert middle > 0.069
    first = answers[begun]
    assert isinstance(first, CurveEstimate)
    assert first.samples == begun


@pytest.mark.parametrize("name", NAMES)
def test_a_refused_sample_leaves_the_estimate_as_it_was(clean: Brake, name: str) -> None:
    samples = clean("wet").samples
    disturbed, calm = exact_wheel_estimator(name, WHEEL), exact_wheel_estimator(name, WHEEL)
    for sample in samples[:60]:
        disturbed.update(sample)
        calm.update(sample)
    for garbage in (
        samples[60]._replace(wheel_speed=math.nan),
        samples[60]._replace(vehicle_speed=-1.0),
        samples[60]._replace(brake_torque=None),
        samples[60]._replace(brake_torque=1e12),
        samples[59],
    ):
        refusal = disturbed.update(garbage)
        assert isinstance(refusal, Refusal)
        assert refusal.text
    after, expected = disturbed.update(samples[60]), calm.update(samples[60])
    assert isinstance(after, CurveEstimate)
    assert isinstance(expected, CurveEstimate)
    assert after.lambda_max == expected.lambda_max
    assert after.samples == expected.samples


@pytest.mark.parametrize("source", FrictionSource)
@pytest.mark.parametrize("name", NAMES)
def test_constant_slip_says_that_there_is_no_excitation(name: str, source: FrictionSource) -> None:
    """Vehicle and wheel slow down together: mu = 0.5 at a slip of 0.02."""
    wheel, slip, deceleration = WHEEL, 0.02, 0.5 * 9.81
    rolling = (1.0 - slip) / wheel.radius
    torque = wheel.radius * 0.5 * wheel.vertical_load + wheel.inertia * rolling * deceleration
    estimator = exact_wheel_estimator(name, WHEEL, source=source)
    for k in range(100):
        speed = 30.0 - deceleration * k * INTERVAL
        answer = estimator.update(Sample(k * INTERVAL, rolling * speed, speed, torque))
        assert isinstance(answer, Refusal)
        assert answer.reason is (Reason.NOT_READY if k < 20 else Reason.NO_EXCITATION)


@pytest.mark.parametrize("name", NAMES)
def test_a_gap_begins_a_new_fit_and_says_so(clean: Brake, name: str) -> None:
    samples = list(clean("dry").samples)
    estimator = exact_wheel_estimator(name, WHEEL)
    for sample in samples[:50]:
        estimator.update(sample)
    later = [sample._replace(time=sample.time + 3.0) for sample in samples]
    answers = [answer for answer in map(estimator.update, later) if isinstance(answer, CurveEstimate)]
    assert answers[0].restarted
    assert answers[0].restart_cause is RestartCause.GAP
    assert not any(answer.restarted for answer in answers[1:])
    fresh = exact_wheel_estimator(name, WHEEL)
    expected = [fresh.update(sample) for sample in later][-1]
    assert isinstance(expected, CurveEstimate)
    assert answers[-1].lambda_max == pytest.approx(expected.lambda_max, rel=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_the_next_braking_begins_a_new_fit(clean: Brake, name: str) -> None:
    """Wet road, brake released for a second, then dry: nothing of the wet road remains."""
    estimator = exact_wheel_estimator(name, WHEEL)
    wet = list(clean("wet").samples)
    for sample in wet:
        estimator.update(sample)
    time = wet[-1].time
    rolling = [Sample(time + k * INTERVAL, 100.0, 30.0, 0.0) for k in range(1, 201)]
    answers = [estimator.update(sample) for sample in rolling]
    assert answers[-1].reason is Reason.NO_EXCITATION
    dry = [sample._replace(time=rolling[-1].time + INTERVAL + sample.time) for sample in clean("dry").samples]
    last = [estimator.update(sample) for sample in dry][-1]
    assert isinstance(last, CurveEstimate)
    assert last.mu_max == pytest.approx(1.17, rel=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_reset_begins_again_and_says_that_it_was_asked_to(clean: Brake, name: str) -> None:
    estimator, fresh = exact_wheel_estimator(name, WHEEL), exact_wheel_estimator(name, WHEEL)
    for sample in clean("wet").samples:
        estimator.update(sample)
    estimator.reset()
    for sample in clean("dry").samples:
        after, expected = estimator.update(sample), fresh.update(sample)
        if isinstance(after, CurveEstimate) and isinstance(expected, CurveEstimate):
            assert after.lambda_max == pytest.approx(expected.lambda_max, nan_ok=True)
            assert after.restarted == (after.samples == 20)
            assert after.restart_cause is (RestartCause.REQUEST if after.restarted else RestartCause.NONE)


def test_an_unknown_method_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="kalman"):
        exact_wheel_estimator("kalman", WHEEL)


ANY = st.one_of(st.floats(), st.floats(0.0, 200.0), st.just(30.0), st.just(0.0))
HOSTILE = st.builds(
    Sample, st.one_of(ANY, st.floats(0.0, 1.0)), ANY, st.one_of(st.none(), ANY), st.one_of(st.none(), ANY)
)


@pytest.mark.parametrize("source", FrictionSource)
@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=10)
@given(hostile=st.lists(st.tuples(st.integers(0, 60), HOSTILE), max_size=25))
def test_hostile_streams_are_answered_and_survived(
    clean_stream: list[Sample], name: str, source: FrictionSource, hostile: list[tuple[int, Sample]]
) -> None:
    estimator = exact_wheel_estimator(name, WHEEL, source=source)
    stream = list(clean_stream)
    for place, sample in hostile:
        stream.insert(place, sample)
    for sample in stream:
        answer = estimator.update(sample)
        if isinstance(answer, CurveEstimate):
            assert math.isnan(answer.lambda_max) or 0.0 < answer.lambda_max < 1.0
            assert -1.0 < answer.slip < 1.0
            assert math.isfinite(answer.mu)
        else:
            assert answer.text


@pytest.fixture(scope="module")
def clean_stream(clean: Brake) -> list[Sample]:
    return list(clean("dry", 60).samples)
