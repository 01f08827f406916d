"""SINDy, on matrices with known sparse solutions."""

import numpy as np

from experiments.exam.methods.regression import Regression
from experiments.exam.methods.sindy import inclusion, sparse
from rallygap.models.gap.hypotheses import Hypothesis


def rows(*coefficients, seed=0):
    """Terms of unit length, and a sum of them in unit noise."""
    random = np.random.default_rng(seed)
    terms = random.standard_normal((40, 50, len(coefficients)))
    scale = np.sqrt((terms**2).sum(axis=(0, 1)))
    noise = random.standard_normal((40, 50))
    return np.concatenate([terms, (terms / scale @ coefficients + noise)[..., None]], axis=2)


def gram(*coefficients):
    flat = rows(*coefficients).reshape(-1, len(coefficients) + 1)
    return flat.T @ flat


def test_terms_above_the_threshold_are_kept_whatever_their_scale():
    table = gram(20.0, 0.0, -12.0, 3.0, 0.0)
    scale = np.diag([1e-6, 1.0, 1e6, 1.0, 1.0, 1.0])
    assert sparse(scale @ table @ scale, 7.0) == (0, 2)
    assert sparse(table, 40.0) == ()


def test_an_ensemble_includes_what_most_of_its_models_do():
    table = rows(20.0, 0.0, 7.0)
    columns = tuple(Hypothesis("wind", axis) for axis in "xyz")
    regression = Regression.of(columns, np.swapaxes(table, 1, 2) @ table)
    weights = np.random.default_rng(0).multinomial(40, np.full(40, 1 / 40), 100)
    included = inclusion(regression, weights.astype(float), 7.0)
    assert included[0] == 1.0
    assert included[1] == 0.0
    assert 0.2 < included[2] < 0.8
