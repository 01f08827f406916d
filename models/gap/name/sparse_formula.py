"""Sparse formulas of omnibus terms: thresholded least squares (Brunton et al. 2016)."""

import warnings
from collections.abc import Sequence

import numpy as np

from models.ball.types import Floats
from models.gap.settings import NameSettings


def formula(names: Sequence[str], rows: Floats, target: Floats, settings: NameSettings) -> str:
    """Return the sparsest formula of enough of the structure.

    Args:
        names: of D terms.
        rows: (E, D) their columns, white.
        target: (E,) what they are to explain, white.
        settings: of naming.
    """
    scale = np.linalg.norm(rows, axis=0)
    coefficients = _sparse(rows / scale, target, settings)
    chosen = np.flatnonzero(coefficients).tolist()
    values = (coefficients / scale)[chosen]
    return " ".join(f"{value:+.3g} [{names[k]}]" for k, value in zip(chosen, values, strict=True))


def _sparse(rows: Floats, target: Floats, settings: NameSettings) -> Floats:
    from pysindy.optimizers import STLSQ  # slow to import, and rarely needed

    coefficients: Floats = np.zeros(rows.shape[1])
    for threshold in settings.formula_thresholds:
        model = STLSQ(threshold=float(threshold), alpha=settings.formula_ridge)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that nothing passes
            coefficients = np.ravel(model.fit(rows, target[:, None]).coef_)
        missed = target - rows @ coefficients
        if missed @ missed < (1 - settings.formula_share) * (target @ target):
            break
    return coefficients
