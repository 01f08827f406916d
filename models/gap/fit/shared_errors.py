"""Shared errors: random effects that all shots have in common, integrated out.

After a shot's nuisance parameters are eliminated (projection.py), K hypotheses and F coefficients
of shared errors remain, these with a Gaussian prior of precision L. With A and U the information
and scores of all shots, ``P = A_ff + L`` and the mixing ``C = A_kf P^-1``,

    information = A_kk - C A_fk,    scores = U_k - C U_f,

and each shot s has its part ``u_k - A_kf c - C (u_f - A_ff c)`` with ``c = P^-1 U_f``. The parts of
all shots lack ``C L c`` and ``C L C'``, which is the prior's own part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.projection import ReducedSystem, identifiable_directions


@dataclass(frozen=True)
class SharedErrors:
    """All shots' information on K hypotheses and F coefficients of shared errors.

    Attributes:
        information: (K + F, K + F) of all shots, without the prior.
        scores: (K + F,) of all shots.
        count: K.
        precision: of the prior of each coefficient.
    """

    information: Floats
    scores: Floats
    count: int
    precision: float = 1.0

    @classmethod
    def of(cls, system: ReducedSystem, count: int) -> "SharedErrors":
        """Return the sums over shots."""
        return cls(system.information.sum(axis=0), system.scores.sum(axis=0), count)

    def from_departures(self, changes: Floats) -> "SharedErrors":
        """Return the same, linearised about values of the hypotheses lower by (K,) changes."""
        return replace(self, scores=self.scores + self.information[:, : self.count] @ changes)

    def about(self, places: Sequence[int]) -> "SharedErrors":
        """Return the same about some of the hypotheses; the others keep their values."""
        kept = [*places, *range(self.count, len(self.scores))]
        information = self.information[np.ix_(kept, kept)]
        return replace(self, information=information, scores=self.scores[kept], count=len(places))

    @cached_property
    def with_prior(self) -> Floats:
        """(K + F, K + F) information of shots and prior."""
        prior = np.zeros(len(self.scores))
        prior[self.count :] = self.precision
        return self.information + np.diag(prior)

    @cached_property
    def mixing(self) -> Floats:
        """(K, F) by which scores of the coefficients enter those of the hypotheses."""
        k = self.count
        mixing = np.linalg.solve(self.with_prior[k:, k:], self.information[k:, :k])
        return np.asarray(mixing.T, dtype=np.float64)

    def coefficients(self, values: Floats) -> Floats:
        """Return the (F,) maximum-likelihood coefficients, given (K,) changes of the hypotheses."""
        k = self.count
        left = self.scores[k:] - self.information[k:, :k] @ values
        return np.asarray(np.linalg.solve(self.with_prior[k:, k:], left), dtype=np.float64)

    @property
    def alone(self) -> tuple[Floats, Floats]:
        """(K, K) information and (K,) scores of the hypotheses, without any shared errors."""
        k = self.count
        return self.information[:k, :k], self.scores[:k]

    @property
    def marginal(self) -> tuple[Floats, Floats]:
        """(K, K) information and (K,) scores of the hypotheses, shared errors integrated out."""
        k = self.count
        information = self.information[:k, :k] - self.mixing @ self.information[k:, :k]
        return information, self.scores[:k] - self.mixing @ self.scores[k:]

    @property
    def explained(self) -> float:
        """By how much shared errors reduce the misfit at the present values of the hypotheses."""
        nothing = np.zeros(self.count)
        return float(self.scores[self.count :] @ self.coefficients(nothing))

    def parts(self, system: ReducedSystem) -> tuple[Floats, Floats]:
        """Return scores and information of the hypotheses: B rows of shots, then the prior's row.

        Without shared errors there is no such row.
        """
        k, mixing = self.count, self.mixing
        if mixing.shape[1] == 0:
            return system.scores, system.information
        a, c = system.information, self.coefficients(np.zeros(k))
        rest = system.scores - a[:, :, k:] @ c
        across = a[:, :k, k:] - mixing @ a[:, k:, k:]
        of_shots = a[:, :k, :k] - mixing @ a[:, k:, :k] - across @ mixing.T
        of_prior = self.precision * mixing
        scores = np.vstack([rest[:, :k] - rest[:, k:] @ mixing.T, of_prior @ c])
        return scores, np.concatenate([of_shots, (of_prior @ mixing.T)[None]])


@dataclass(frozen=True)
class VarianceLikelihood:
    """Restricted likelihood of the standard deviation of random effects, hypotheses free.

    Along its eigenvectors the information of the coefficients is l and their score w, so that twice
    the negative log likelihood of a variance v, less that of none, is the sum of
    ``log(1 + v l) - v w^2 / (1 + v l)``.

    Attributes:
        information: (F,) l.
        scores: (F,) w.
        bounds: of the standard deviation.
    """

    information: Floats
    scores: Floats
    bounds: tuple[float, float]

    @classmethod
    def of(cls, shared: SharedErrors, bounds: tuple[float, float]) -> "VarianceLikelihood":
        """Return the likelihood by the information of all shots."""
        k, a, u = shared.count, shared.information, shared.scores
        directions = identifiable_directions(a[:k, :k])
        mixed = a[k:, :k] @ directions
        values, vectors = np.linalg.eigh(a[k:, k:] - mixed @ mixed.T)
        scores = vectors.T @ (u[k:] - mixed @ (directions.T @ u[:k]))
        return cls(np.maximum(values, 0.0), scores, bounds)

    def deviance(self, size: float) -> float:
        """Return twice the negative log likelihood of a standard deviation, less that of zero."""
        growth = 1.0 + size**2 * self.information
        return float((np.log(growth) - size**2 * self.scores**2 / growth).sum())

    @cached_property
    def estimate(self) -> float:
        """The maximum-likelihood standard deviation."""
        low, high = np.log(self.bounds)
        grid = np.linspace(low, high, 40)
        best = int(np.argmin([self.deviance(float(np.exp(one))) for one in grid]))
        ends = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)])
        found = minimize_scalar(
            lambda log: self.deviance(float(np.exp(log))), bounds=ends, method="bounded"
        )
        return float(np.exp(found.x))

    def interval(self, confidence: float) -> tuple[float, float]:
        """Return the standard deviations that are nearly as likely (profile likelihood)."""
        limit = float(chi2.ppf(confidence, 1)) - self.gain

        def excess(log: float) -> float:
            return self.deviance(float(np.exp(log))) - limit

        def reached(end: float) -> float:
            start, stop = float(np.log(self.estimate)), float(np.log(end))
            inside = excess(stop) <= 0.0
            return end if inside else float(np.exp(brentq(excess, start, stop)))

        return reached(self.bounds[0]), reached(self.bounds[1])

    @property
    def gain(self) -> float:
        """Twice the gain of log likelihood by the estimate."""
        return max(-self.deviance(self.estimate), 0.0)


def variance_p_value(gain: float) -> float:
    """Return the p-value of a likelihood ratio against the hypothesis that a variance is zero.

    Under it the ratio is zero with probability 1/2, else chi-squared with one degree of freedom
    (Self and Liang 1987).
    """
    return 0.5 * float(chi2.sf(gain, 1)) if gain > 0.0 else 1.0
