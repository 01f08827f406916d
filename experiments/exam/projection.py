"""Projection of nuisance parameters out of linear regressions, one regression a shot."""

import numpy as np

from rallygap.models.ball.types import Floats


def projected_out(rows: Floats, nuisance: Floats, precision: Floats) -> Floats:
    """Return (B, R, C) rows less their regression on (B, R, N) nuisance columns.

    Args:
        rows: of B shots.
        nuisance: slopes by the N nuisance parameters of each shot.
        precision: (B, N) inverse prior variances of these.
    """
    transposed = np.swapaxes(nuisance, 1, 2)
    information = transposed @ nuisance + precision[:, :, None] * np.eye(nuisance.shape[2])
    return rows - nuisance @ np.linalg.solve(information, transposed @ rows)
