"""Scores of shots: what a regression says about its terms, with the noise that shots really have.

Errors within a shot are correlated, because a scattered bounce or slow noise of the cameras changes
all that follows. The rows of a regression are not independent then, but shots are. The spread of
the shots' scores is the covariance of the noise, as in generalised estimating equations (Liang and
Zeger 1986).
"""

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.exam.methods.regression import Regression

# That the expected covariance counts for. Of clean sets of 10 shots, 100, 98 and 96 % are right for
# 40, 60 and 100; of 100 shots all are, and 88 % of the effects that are added to them are named.
PRIOR_SHOTS = 40
MINIMUM_SINGULAR_VALUE = 1e-3  # of the largest, in the fit of the whole library
RIDGE = 1e-6  # of the covariance of unit terms


def score_gram(regression: Regression) -> Floats:
    """Return the (K + 1, K + 1) Gram matrix of the total scores, in units of their noise.

    The scores b = F'r of K terms F are G theta + noise, with the Gram matrix G = F'F. Divided by
    their noise, they are K rows of terms and a measured value, with independent unit noise.
    """
    scale = np.append(term_norms(regression), 1.0)
    total = regression.total / np.outer(scale, scale)
    covariance = _covariance(regression.grams / np.outer(scale, scale), total)
    scores = total[:-1]
    gram: Floats = scores.T @ np.linalg.solve(covariance, scores) * np.outer(scale, scale)
    return gram


def term_norms(regression: Regression) -> Floats:
    """Return the (K,) norms of the terms: one over the white noise of each alone."""
    norms = np.sqrt(np.diag(regression.total)[:-1])
    return np.where(norms > 0.0, norms, 1.0)


def _covariance(grams: Floats, total: Floats) -> Floats:
    """Return the (K, K) covariance of the total scores of unit terms, about the whole fit.

    It is the posterior mean of an inverse Wishart prior, because few shots say little of it. What
    the prior expects is the covariance of independent rows, times the median inflation, at least 1.
    """
    inner, count = total[:-1, :-1], len(grams)
    whole = np.linalg.lstsq(inner, total[:-1, -1], rcond=MINIMUM_SINGULAR_VALUE)[0]
    scores = grams[:, :-1, -1] - grams[:, :-1, :-1] @ whole
    spread = scores.T @ scores
    inflation = max(float(np.median(np.diag(spread))), 1.0)
    expected = inflation * inner + RIDGE * np.eye(len(inner))
    freedom = count + PRIOR_SHOTS - len(inner) - 1
    covariance: Floats = (count * spread + PRIOR_SHOTS * expected) / freedom
    return covariance
