"""Samples are found by their indices, whatever was added and dropped before."""

from __future__ import annotations

import numpy as np

from smart_tyre_forces.sample_buffer import SampleBuffer


def test_samples_are_found_by_their_indices() -> None:
    signal = np.sin(np.arange(100_000.0))
    kept = SampleBuffer(1000)
    assert (len(kept), kept.next) == (0, 1000)
    begin, end = 0, 0
    for number, length in enumerate(np.random.default_rng(1).integers(1, 3000, 60)):
        kept.append(signal[end : end + length])
        end += length
        if number % 7 == 6:
            begin = end - 500
            kept.drop_before(1000 + begin)
            kept.drop_before(1000 + begin - 100)
        assert (kept.first, kept.next, len(kept)) == (1000 + begin, 1000 + end, end - begin)
        assert np.array_equal(kept.get(1000 + begin, end - begin), signal[begin:end])
        assert np.array_equal(kept.get(1000 + end - 1, 1), signal[end - 1 : end])


def test_a_block_longer_than_the_array_is_kept_whole_and_missing_samples_stay_missing() -> None:
    kept = SampleBuffer(0)
    block = np.array([np.nan, 1.0, 2.0] * 5000, dtype=np.float32)
    kept.append(block)
    assert np.array_equal(kept.get(0, len(block)), block, equal_nan=True)


def test_what_is_dropped_does_not_fill_the_memory() -> None:
    kept = SampleBuffer(0)
    for _ in range(5000):
        kept.append(np.zeros(50))
        kept.drop_before(kept.next - 1000)
    assert kept.get(kept.first, 1).base is not None
    assert len(np.asarray(kept.get(kept.first, 1).base)) < 10_000
