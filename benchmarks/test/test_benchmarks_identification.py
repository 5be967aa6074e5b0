"""Statistics of the identification part on traces made by hand, and the columns of its table."""

import argparse

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from benchmarks.identification import part as identification
from benchmarks.identification.part import roads, seeds_of
from benchmarks.identification.runs import SERIES, Batch, Traces, coverage, kept_from, measured, peak_row
from benchmarks.protocol import braking

Array = NDArray[np.float64]

TRUTH = np.full(4, 0.2)


def traces(**series: Array) -> Traces:
    shape = next(iter(series.values())).shape
    values = np.full((*shape, len(SERIES)), np.nan)
    for name, value in series.items():
        values[:, :, SERIES.index(name)] = value
    return Traces(values, 0)


def at_end(values: list[float]) -> Array:
    return np.tile(np.array(values)[:, np.newaxis], (1, 3))


def test_failures_are_counted_and_weigh_a_hundred_percent() -> None:
    found = traces(
        lambda_max=at_end([0.21, 0.19, 0.4, np.nan]),
        lambda_max_stddev=at_end([0.02, 0.001, 0.1, np.nan]),
        mu_max=at_end([1.0, 1.1, 0.9, np.nan]),
        mu_max_stddev=at_end([0.1, 0.1, 0.1, np.nan]),
        valid=at_end([1.0, 0.0, 0.0, 0.0]),
        milliseconds=at_end([0.1, 0.2, 0.3, 0.4]),
    )
    row = peak_row(found, TRUTH, np.ones(4), 3)
    assert row["failures"] == 2
    assert row["bias_pct"] == pytest.approx((5.0 - 5.0 + 100.0) / 3)
    assert row["rmse_pct"] == pytest.approx(((25.0 + 25.0 + 1e4) / 3) ** 0.5)
    assert row["median_pct"] == pytest.approx((5.0 + 100.0) / 2)
    assert row["coverage_95"] == pytest.approx(100.0 / 3)
    assert row["valid_pct"] == 25.0
    assert row["update_ms_median"] == pytest.approx(0.25)


def test_coverage_of_a_normal_error_is_what_it_says() -> None:
    generator = np.random.default_rng(0)
    error = generator.normal(0.0, 1.0, 20_000)
    assert coverage(error, np.ones(20_000), np.zeros(20_000)) == pytest.approx(95.0, abs=0.6)
    assert np.isnan(coverage(error, np.full(20_000, np.nan), np.zeros(20_000)))


def test_an_error_is_kept_from_the_sample_after_its_last_excess() -> None:
    estimate = np.array([[np.nan, 0.3, 0.21, 0.3, 0.205], [0.3, 0.2, 0.2, 0.2, 0.2], [0.2, 0.2, 0.2, 0.2, 0.2]])
    assert kept_from(traces(lambda_max=estimate), TRUTH[:3], 10.0) == 2.0
    assert kept_from(traces(lambda_max=estimate[:1]), TRUTH[:1], 10.0) == 5.0
    assert kept_from(traces(lambda_max=estimate[:1]), TRUTH[:1], 1.0) == np.inf


def test_the_same_seed_gives_the_same_noise_and_every_method_the_same_samples() -> None:
    truth = braking("B", roads()[:1])
    number, seed = seeds_of(0, 1)[0]
    first, second = (list(measured(Batch("", method, truth, []), number, seed)) for method in ("ml", "ls"))
    assert first == second


def test_the_table_has_the_promised_columns() -> None:
    parser = argparse.ArgumentParser()
    identification.add_arguments(parser)
    rows = identification.run(parser.parse_args(["--seeds", "2", "--methods", "ml"]))
    promised = """surface method samples runs bias_pct rmse_pct median_pct p95_pct failures coverage_95 crlb_pct
               update_ms_median update_ms_p99""".split()
    assert len(rows) == 4 * 3
    for row in rows:
        assert set(promised) <= set(row)
        assert row["runs"] == 2 and row["divergences"] == 0
    assert {row["samples"] for row in rows} == {40, 70, 100}
    bounds = [row["crlb_pct"] for row in rows if row["samples"] == 100]
    assert_allclose(bounds, [0.889, 1.56, 0.428, 14.4], rtol=0.01)
