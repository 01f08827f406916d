"""Elimination of nuisance parameters by projection: Schur complements of information matrices.

With the columns ``[G F r]`` of a shot in the metric of its noise, eliminating the block of G leaves

    A = F'MF (information),   u = F'Mr (score),   q = r'Mr,    M = 1 - G (G'G)^-1 G',

and the restricted log likelihood of all shots (REML, Patterson and Thompson 1971), the values of
the hypotheses integrated out as well, is
``-1/2 [log|R| + log|P| + sum log|G'G| + log|A| + q - u'A^-1 u]`` with R the noise and P the priors.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Floats

RANK_TOLERANCE = 1e-5  # of the correlation matrix of information; below, nothing is identifiable


@dataclass(frozen=True)
class ReducedSystem:
    """B shots whose nuisance parameters are eliminated; K hypotheses remain.

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


def eliminate_nuisance(gram_matrices: Floats, count: int) -> ReducedSystem:
    """Eliminate the first ``count`` columns of (B, C, C) Gram matrices; the residual is last."""
    inner, mixed = gram_matrices[:, :count, :count], gram_matrices[:, :count, count:]
    left = gram_matrices[:, count:, count:] - np.swapaxes(mixed, 1, 2) @ np.linalg.solve(
        inner, mixed
    )
    determinants = np.linalg.slogdet(inner)[1]
    return ReducedSystem(left[:, :-1, :-1], left[:, :-1, -1], left[:, -1, -1], determinants)


def nuisance_solution(gram_matrices: Floats, count: int, values: Floats) -> Floats:
    """Return (B, count) best changes of the nuisance parameters, given (K,) hypotheses' changes."""
    right = gram_matrices[:, :count, -1] - gram_matrices[:, :count, count:-1] @ values
    best = np.linalg.solve(gram_matrices[:, :count, :count], right[..., None])[..., 0]
    return np.asarray(best, dtype=np.float64)


def identifiable_directions(
    information: Floats, scale: Floats | None = None, tolerance: float = RANK_TOLERANCE
) -> Floats:
    """Return (K, D) directions in which data of this (K, K) information identify values.

    They are orthonormal in its metric, so along them scores have unit variance.

    Args:
        information: symmetric.
        scale: (K,) units of the columns; by their own information where left out.
        tolerance: least eigenvalue in these units.
    """
    if scale is None:
        scale = np.sqrt(np.maximum(np.diag(information), 0.0))
        scale = np.where(scale > 0.0, scale, np.inf)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = values > tolerance
    directions: Floats = vectors[:, kept] / scale[:, None] / np.sqrt(values[kept])
    return directions


@dataclass(frozen=True)
class Projection:
    """Projection of K columns on a block of D of them, given N others that are free.

    With ``theta = A_nn^-1 U_n`` the others' values and ``C = A_kn A_nn^-1`` (mixing), the efficient
    scores of the block and their information are

        e = (u_k - A_kn theta) - C (u_n - A_nn theta),    I = A_kk - C A_nk - (A_kn - C A_nn) C'.

    The last term vanishes for the data that C is from, not for other data (single shots).

    Attributes:
        block: places of the D columns.
        given: places of the N others.
        values: (N,) of the others.
        mixing: (D, N).
    """

    block: list[int]
    given: list[int]
    values: Floats
    mixing: Floats

    @classmethod
    def of(cls, total: Floats, scores: Floats, block: list[int], given: list[int]) -> "Projection":
        """Return the projection by the (K, K) information of all data and its (B, K) scores."""
        inner = regularised(total[np.ix_(given, given)])
        values: Floats = np.linalg.solve(inner, scores[:, given].sum(axis=0))
        mixing = np.linalg.solve(inner, total[np.ix_(given, block)])
        return cls(block, given, values, np.asarray(mixing.T, dtype=np.float64))

    def scores(self, scores: Floats, information: Floats) -> Floats:
        """Return (B, D) efficient scores of (B, K) scores and (B, K, K) information."""
        rest = scores - information[:, :, self.given] @ self.values
        return rest[:, self.block] - rest[:, self.given] @ self.mixing.T

    def information(self, information: Floats) -> Floats:
        """Return (B, D, D) information of the efficient scores of (B, K, K) data."""
        a, k, n = information, self.block, self.given
        across = a[:, k][:, :, n] - self.mixing @ a[:, n][:, :, n]
        of_block: Floats = a[:, k][:, :, k] - self.mixing @ a[:, n][:, :, k]
        return of_block - across @ self.mixing.T

    def information_diagonal(self, information: Floats) -> Floats:
        """Return the (B, D) diagonals of ``information`` alone, for many columns."""
        a, k, n = information, self.block, self.given
        mixed = np.einsum("dn,bnd->bd", self.mixing, a[:, n][:, :, k])
        twice = ((a[:, n][:, :, n] @ self.mixing.T) * self.mixing.T).sum(axis=1)
        diagonal: Floats = np.einsum("bkk->bk", a)[:, k] - 2 * mixed + twice
        return diagonal


def regularised(matrix: Floats) -> Floats:
    """Return information matrices that can be inverted where columns are exactly collinear."""
    size = matrix.shape[-1]
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)[..., None] * np.eye(size)
    return matrix + 1e-10 * diagonal + 1e-300 * np.eye(size)
