"""Marginal likelihood: shots without their unknowns, all by the Schur complement of a Gram matrix.

With the columns ``[G F r]`` of a shot in the metric of its noise, eliminating the block of G leaves

    A = F'MF (information),   u = F'Mr (score),   q = r'Mr,    M = 1 - G (G'G)^-1 G',

and the restricted log likelihood of all shots, the hypotheses' values integrated out as well, is
``-1/2 [log|R| + log|P| + sum log|G'G| + log|A| + q - u'A^-1 u]`` with R the noise and P the priors.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.types import Floats

SMALLEST_EIGENVALUE = 1e-5  # of the information's correlation matrix; directions below are unseen


@dataclass(frozen=True)
class Marginal:
    """B shots of which K hypotheses are left.

    Attributes:
        information: (B, K, K).
        scores: (B, K).
        misfit: (B,) squared error in units of the noise.
        determinants: (B,) log determinants of the eliminated blocks.
    """

    information: Floats
    scores: Floats
    misfit: Floats
    determinants: Floats


def marginal(grams: Floats, own: int) -> Marginal:
    """Eliminate the first ``own`` columns of (B, C, C) Gram matrices, the residual's being last."""
    inner, mixed = grams[:, :own, :own], grams[:, :own, own:]
    left = grams[:, own:, own:] - np.swapaxes(mixed, 1, 2) @ np.linalg.solve(inner, mixed)
    determinants = np.linalg.slogdet(inner)[1]
    return Marginal(left[:, :-1, :-1], left[:, :-1, -1], left[:, -1, -1], determinants)


def coefficients(grams: Floats, own: int, values: Floats) -> Floats:
    """Return (B, own) the unknowns' best changes where hypotheses change by given (K,) values."""
    right = grams[:, :own, -1] - grams[:, :own, own:-1] @ values
    best = np.linalg.solve(grams[:, :own, :own], right[..., None])[..., 0]
    return np.asarray(best, dtype=np.float64)


def visible(information: Floats) -> Floats:
    """Return (K, D) directions in which data of this (K, K) information say something.

    They are orthonormal in its metric, so along them scores have unit variance.
    """
    scale = np.sqrt(np.maximum(np.diag(information), 0.0))
    scale = np.where(scale > 0.0, scale, np.inf)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = values > SMALLEST_EIGENVALUE
    directions: Floats = vectors[:, kept] / scale[:, None] / np.sqrt(values[kept])
    return directions
