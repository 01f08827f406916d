"""Lead: a sparse formula for structure without a name, by pysindy's thresholded least squares."""

import warnings
from collections.abc import Sequence

import numpy as np

from models.ball.types import Floats

THRESHOLDS = np.geomspace(30.0, 3.0, 12)  # in standard deviations
RIDGE = 0.05  # terms that are nearly alike must not cancel
ENOUGH = 0.8  # of what all terms explain


def formula(names: Sequence[str], rows: Floats, target: Floats) -> str:
    """Return the sparsest formula of enough of the structure.

    Args:
        names: of D terms.
        rows: (E, D) their columns, white.
        target: (E,) what they are to explain, white.
    """
    scale = np.linalg.norm(rows, axis=0)
    coefficients = _sparse(rows / scale, target)
    chosen = np.flatnonzero(coefficients).tolist()
    values = (coefficients / scale)[chosen]
    return " ".join(f"{value:+.3g} [{names[k]}]" for k, value in zip(chosen, values, strict=True))


def _sparse(rows: Floats, target: Floats) -> Floats:
    from pysindy.optimizers import STLSQ  # slow to import, and rarely needed

    coefficients: Floats = np.zeros(rows.shape[1])
    for threshold in THRESHOLDS:
        model = STLSQ(threshold=float(threshold), alpha=RIDGE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that nothing passes
            coefficients = np.ravel(model.fit(rows, target[:, None]).coef_)
        missed = target - rows @ coefficients
        if missed @ missed < (1 - ENOUGH) * (target @ target):
            break
    return coefficients
