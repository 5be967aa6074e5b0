"""Tyre forces as a friction source: the ratio alone counts, bad forces are refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_curve_id.chapter.tyre_force import TyreForceFitting, TyreForceParameters, TyreForceSample
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface


def braking(name: str = "wet", load: float = 3000.0) -> list[TyreForceSample]:
    """Forces once a revolution while the slip rises to 0.4, the load oscillating by a tenth."""
    generator, samples = np.random.default_rng(4), []
    for k, slip in enumerate(np.linspace(0.0, 0.4, 80)):
        vertical = load * (1.0 + 0.1 * math.sin(k))
        friction = float(burckhardt.friction(surface(name), slip)) + generator.normal(0.0, 0.01)
        samples.append(TyreForceSample(0.07 * k, float(slip), -friction * vertical, vertical))
    return samples


@pytest.mark.parametrize("load", [1000.0, 8000.0])
def test_finds_the_peak_whatever_the_load(load: float) -> None:
    fitting = TyreForceFitting()
    estimate = [fitting.update(sample) for sample in braking(load=load)][-1]
    assert isinstance(estimate, CurveEstimate)
    lambda_max, mu_max = burckhardt.peak(surface("wet"))
    assert estimate.valid
    assert estimate.lambda_max == pytest.approx(lambda_max, rel=0.1)
    assert estimate.mu_max == pytest.approx(mu_max, rel=0.02)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"longitudinal_force": math.nan}, Reason.BAD_INPUT),
        ({"slip": 1.5}, Reason.NO_SLIP),
        ({"vertical_load": 0.0}, Reason.BAD_INPUT),
        ({"vertical_load": -3000.0}, Reason.BAD_INPUT),
        ({"longitudinal_force": -1e6}, Reason.BAD_INPUT),
        ({"time": 39 * 0.07}, Reason.BAD_INPUT),
    ],
)
def test_a_bad_sample_is_refused_and_leaves_the_fit_as_it_was(change: dict[str, float], reason: Reason) -> None:
    disturbed, calm = TyreForceFitting(), TyreForceFitting()
    samples = braking()
    for sample in samples[:40]:
        disturbed.update(sample)
        calm.update(sample)
    refusal = disturbed.update(replace(samples[40], **change))
    assert isinstance(refusal, Refusal)
    assert refusal.reason is reason
    after, expected = disturbed.update(samples[40]), calm.update(samples[40])
    assert isinstance(after, CurveEstimate)
    assert isinstance(expected, CurveEstimate)
    assert (after.samples, after.lambda_max) == (expected.samples, expected.lambda_max)


def test_a_gap_begins_a_new_fit() -> None:
    fitting = TyreForceFitting()
    for sample in braking("wet"):
        fitting.update(sample)
    answers = [fitting.update(replace(sample, time=sample.time + 60.0)) for sample in braking("dry")]
    estimates = [answer for answer in answers if isinstance(answer, CurveEstimate)]
    assert estimates[0].restart_cause is RestartCause.GAP
    assert estimates[-1].mu_max == pytest.approx(1.17, rel=0.02)


def test_the_fit_begins_beyond_lambda_init() -> None:
    fitting = TyreForceFitting(TyreForceParameters(lambda_init=0.2))
    answers = [(sample.slip, fitting.update(sample)) for sample in braking()]
    assert min(slip for slip, answer in answers if isinstance(answer, CurveEstimate)) == pytest.approx(0.2, abs=0.01)


@given(st.lists(st.builds(TyreForceSample, st.floats(), st.floats(), st.floats(), st.floats()), max_size=30))
def test_hostile_streams_are_answered_and_survived(hostile: list[TyreForceSample]) -> None:
    fitting = TyreForceFitting()
    for sample in [*braking()[:30], *hostile, *braking()[30:]]:
        answer = fitting.update(sample)
        assert isinstance(answer, (CurveEstimate, Refusal))
