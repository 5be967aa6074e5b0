"""The chapter as printed: detection without dead zones, and fits of the samples beyond lambda_init alone."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.protocol import braking
from benchmarks.slope.detection import shipped_settings, through_the_peak
from book.slope import VARIANTS, Printed, mean_slips, slips_at_detection
from book.speed_tables import BeyondStart
from friction_curve_id.interface import CurveEstimate, Refusal, Sample
from vehicle_models.surfaces import surface


def test_printed_detection_is_early_at_the_onset_unless_a_torque_is_waited_for() -> None:
    run = through_the_peak("off_road")
    never = replace(VARIANTS[0], h_instability=-1e9)
    variants = (Printed(28, 200.0), Printed(28, 1.0), never)
    slips = np.array([slips_at_detection(run, variants, shipped_settings(imu=True).slip, seed) for seed in range(3)])
    assert slips[:, 0] == pytest.approx(run.lambda_max, rel=0.2)
    assert np.all(slips[:, 1] < 0.05)
    assert np.isnan(slips[:, 2]).all()


def test_each_mean_slip_of_the_chapter_stands_beside_ours() -> None:
    rows, numbers = mean_slips(2)
    assert [row["chapter"] for row in numbers] == [0.0854, 0.0648, 0.1357, 0.1283]
    for row, number in zip(rows, numbers, strict=True):
        assert number["5 %"] <= row["shipped"] <= number["95 %"]


def test_fit_of_the_samples_beyond_lambda_init_waits_for_twenty_of_them() -> None:
    truth = braking("B", surface("high_grip"))
    estimator = BeyondStart("rls", 0.07)
    answers = [
        estimator.update(Sample(float(t), float(w), float(v), float(torque)))
        for t, w, v, torque in zip(truth.time, truth.wheel_speed[0], truth.speed[0], truth.torque[0], strict=True)
    ]
    first = next(k for k, answer in enumerate(answers) if isinstance(answer, CurveEstimate))
    passed = int(np.argmax(truth.slip[0] > 0.07))
    assert first == pytest.approx(passed + 19, abs=1)
    assert isinstance(answers[passed - 1], Refusal)
    last = answers[-1]
    assert isinstance(last, CurveEstimate)
    assert last.lambda_max == pytest.approx(0.1, rel=0.1)
    estimator.reset()
    assert isinstance(estimator.update(Sample(0.0, 100.0, 30.0, 0.0)), Refusal)
