"""The chapter as printed: detection without dead zones, and fits of the samples beyond lambda_init alone."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.protocol import braking
from benchmarks.slope.detection import shipped_settings, through_the_peak
from book.as_printed import VARIANTS, Printed, slips_at_detection
from book.slope_verdicts import mean_slips
from book.speed_tables import BeyondStart
from book.verdicts import Judgement
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


def test_mean_slip_is_judged_by_the_shipped_one_and_explained_by_the_nearest_printed_one() -> None:
    roads = (("high_grip", 0.0854, 0.1), ("off_road", 0.1357, 0.13))
    rows = [
        {"road": road, "equation": equation, "chapter": chapter, "lambda_max": peak, "shipped: early [%]": 0.0}
        | {"shipped": 0.11 if road == "high_grip" else 0.135}
        | {f"printed: 28 samples, T_b above {torque} N m": slip for torque, slip in ((100, 0.12), (30, 0.08))}
        | {f"printed: 28 samples, T_b above {torque} N m: early [%]": early for torque, early in ((100, 0), (30, 40))}
        for road, chapter, peak in roads
        for equation in ("(8.4)", "(8.5)")
    ]
    found = {verdict.statement: verdict for verdict in mean_slips(rows)}
    high = found["Mean slip at detection by (8.4), high grip"]
    assert high.judgement is Judgement.DIFFERS
    assert "0.08 (28 samples, T_b above 30 N m) with 40 % of its detections early" in high.because
    assert found["Mean slip at detection by (8.4), low grip"].judgement is Judgement.AGREES
    earlier = [row | ({"shipped": 0.1} if row["equation"] == "(8.5)" else {}) for row in rows]
    what = "Without slip the detection comes at a smaller slip than with it, on both roads"
    assert found[what].judgement is Judgement.DIFFERS
    assert {verdict.statement: verdict for verdict in mean_slips(earlier)}[what].judgement is Judgement.AGREES


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
