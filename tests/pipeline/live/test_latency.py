"""Latencies are counted in constant memory."""

import numpy as np
import pytest

from rallygap.pipeline.live.latency import Latencies, summary


def test_percentiles_are_right_to_a_hundredth_of_a_millisecond():
    seconds = np.random.default_rng(0).gamma(2.0, 2e-4, 10_000)
    latencies = Latencies()
    for one in seconds:
        latencies.add(one)
    for share in (50, 99, 99.9):
        assert latencies.percentile(share) == pytest.approx(
            1e3 * np.percentile(seconds, share), abs=0.011
        )


def test_the_histogram_has_every_frame():
    latencies = Latencies()
    for milliseconds in (0.05, 0.15, 0.15, 3.0, 80.0):
        latencies.add(milliseconds / 1e3)
    lines = latencies.histogram()
    counts = [int(line.split(" ms")[1].replace("and more", "").split()[0]) for line in lines]
    assert counts == [1, 2, 0, 0, 0, 0, 1, 0, 1]
    assert summary(latencies).startswith("5 frames")
    assert summary(Latencies()) == "no frame"
