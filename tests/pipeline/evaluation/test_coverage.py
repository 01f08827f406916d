"""Coverage of calibrated sets: parts that calibrate one another."""

import numpy as np
import pytest

from rallygap.models.predictors.calibration import LEVELS, Errors
from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.pipeline.evaluation.coverage import Coverage

HORIZONS = len(HORIZONS_MS)


def part(size, seed, count=400):
    """Errors of ``size`` m that are said to be of 1 cm."""
    away = size * np.random.default_rng(seed).normal(size=(count, HORIZONS, 3))
    return Errors(away, np.tile(0.01**2 * np.eye(3), (count, HORIZONS, 1, 1)))


def test_parts_alike_cover_what_the_levels_say():
    found = Coverage.crossed([part(0.03, seed) for seed in range(5)])
    table = found.table(np.arange(2000), 50, 0)
    for level in LEVELS:
        rows = table[table["level"] == level]
        assert rows["coverage"].mean() == pytest.approx(level, abs=0.02)
        assert (rows["n"] == 2000).all()


def test_a_part_does_not_calibrate_its_own_sets():
    parts = [part(0.001, 0), part(0.001, 1), part(0.1, 2)]
    covered = Coverage.crossed(parts).covered[LEVELS.index(0.9)]
    assert covered[-400:].mean() < 0.05  # sets by the accurate parts are too small for it
    assert covered[:400].mean() == 1.0
