"""Score tests of hypotheses given others, before any is refitted.

Each shot s gives a block of hypotheses efficient scores ``e_s`` with information ``I_s``, its
nuisance parameters and the given hypotheses eliminated (fit/projection.py; Rao 1948, Neyman 1959).
With ``U = sum e_s`` and ``I = sum I_s``, ``I^-1 U`` is the estimate and ``U'I^-1 U`` the gain of
twice the log likelihood.

Significance comes from the spread of the shots (a cluster-robust variance). The leave-one-out
residual ``d_s = e_s - I_s (I - I_s)^-1 (U - e_s)`` is how far a shot is from the estimate by the
others. The variance of U is ``sum d_s d_s'``, with the effective sample size less one as degrees of
freedom, averaged with the information, the variance by the noise as estimated (an empirical Bayes
variance; Smyth 2004). The test is Hotelling's; p-values of many tests are adjusted for their number
(Sidak 1967).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as fisher
from scipy.stats import t as student

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.projection import Projection, eliminate_nuisance, regularised
from rallygap.models.gap.fit.shared_errors import SharedErrors
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Places


@dataclass(frozen=True)
class ScoreTest:
    """One block of hypotheses, tested given others.

    Attributes:
        block: places of the block's hypotheses.
        scores: (B + of_prior, D) efficient scores of the shots, then of the prior.
        shares: (B + of_prior, D, D) contributions of the same rows to the information.
        settings: of the workflow.
        of_prior: how many of the last rows are not of shots but of the prior of shared errors.
    """

    block: Places
    scores: Floats
    shares: Floats
    settings: GapSettings
    of_prior: int = 0

    @property
    def shots(self) -> slice:
        """Rows of the shots."""
        return slice(len(self.scores) - self.of_prior)

    @cached_property
    def information(self) -> Floats:
        """(D, D) of all shots."""
        information: Floats = self.shares.sum(axis=0)
        return information

    @cached_property
    def estimate(self) -> Floats:
        """(D,) by how much the values differ from the simulator's, to first order."""
        return np.linalg.solve(regularised(self.information), self.scores.sum(axis=0))

    @cached_property
    def standard_error(self) -> Floats:
        """(D,) of each estimate, by the noise as estimated."""
        return np.sqrt(np.diag(np.linalg.inv(self.information)))

    @cached_property
    def gain(self) -> float:
        """Twice the gain of log likelihood."""
        return float(self.scores.sum(axis=0) @ self.estimate)

    @cached_property
    def held_out_gains(self) -> Floats:
        """(B,) twice the gain of log likelihood of each shot by the estimate of other folds."""
        folds = self.settings.inference.folds
        fold = np.arange(len(self.scores)) % folds
        fold[self.shots.stop :] = folds
        gains, total = np.zeros(len(self.scores)), self.scores.sum(axis=0)
        for number in range(folds):
            rows = fold == number
            scores, shares = self.scores[rows], self.shares[rows]
            others = regularised(self.information - shares.sum(axis=0))
            said = np.linalg.solve(others, total - scores.sum(axis=0))
            gains[rows] = 2 * scores @ said - np.einsum("bde,d,e->b", shares, said, said)
        return gains[self.shots]

    @property
    def held_out_gain(self) -> float:
        """Twice the gain of log likelihood of all folds, each by the estimate of the others."""
        return float(self.held_out_gains.sum())

    @property
    def gains_significantly(self) -> bool:
        """Whether the interval of the held-out gain, by its spread over shots, excludes zero."""
        gains = self.held_out_gains
        error = float(np.sqrt(len(gains)) * gains.std())
        return self.held_out_gain > self.settings.normal_quantile * error

    @cached_property
    def effective_sample_size(self) -> float:
        """How many shots of equal information would have this total: no verdict rests on one."""
        parts = np.linalg.solve(regularised(self.information), self.shares[self.shots])
        shares = np.einsum("bdd->b", parts)
        return float(shares.sum() ** 2 / np.maximum((shares**2).sum(), 1e-300))

    @cached_property
    def leave_one_out_residuals(self) -> Floats:
        """(B, D) how far each shot's score is from its prediction by the others."""
        scores, shares = self.scores[self.shots], self.shares[self.shots]
        others = regularised(self.information - shares)
        rest = self.scores.sum(axis=0) - scores
        said = np.linalg.solve(others, rest[..., None])
        return scores - (shares @ said)[..., 0]

    @cached_property
    def degrees(self) -> float:
        """Degrees of freedom of the variance."""
        return max(self.effective_sample_size - 1.0, 0.0) + self.settings.inference.noise_degrees

    @cached_property
    def variance(self) -> Floats:
        """(D, D) of the sum of the scores, by the shots' spread and by the noise."""
        share = self.settings.inference.noise_degrees / self.degrees
        between = self.leave_one_out_residuals.T @ self.leave_one_out_residuals
        between += self.shares[self.shots.stop :].sum(axis=0)
        return (1 - share) * between + share * self.information

    @cached_property
    def p_value(self) -> float:
        """Probability of a gain at least this large without any effect of the block."""
        total, size = self.scores.sum(axis=0), len(self.block)
        squared = float(total @ np.linalg.solve(regularised(self.variance), total))
        rest = max(self.degrees - size + 1, 1.0)
        return float(fisher.sf(squared * rest / (size * self.degrees), size, rest))

    @cached_property
    def margin(self) -> Floats:
        """(D,) half the 95 % interval of each estimate."""
        inverse = np.linalg.inv(regularised(self.information))
        errors = np.sqrt(np.diag(inverse @ self.variance @ inverse))
        margin: Floats = errors * student.isf((1 - self.settings.confidence) / 2, self.degrees)
        return margin


@dataclass(frozen=True)
class Evidence:
    """Scores and information of B shots about K hypotheses.

    Attributes:
        columns: the hypotheses.
        listed: (K,) which of them the simulator lists.
        scores: (B + of_prior, K) of the shots, then of the prior.
        information: (B + of_prior, K, K) of the same rows.
        settings: of the workflow.
        of_prior: how many of the last rows are not of shots but of the prior of shared errors.
    """

    columns: tuple[Hypothesis, ...]
    listed: NDArray[np.bool_]
    scores: Floats
    information: Floats
    settings: GapSettings
    of_prior: int = 0

    @classmethod
    def of(
        cls, linear: Linearised, noise_estimate: NoiseEstimate, settings: GapSettings
    ) -> "Evidence":
        """Return the evidence of linearised shots in the metric of their noise."""
        left = eliminate_nuisance(noise_estimate.gram_matrices, linear.nuisance_count)
        shared = SharedErrors.of(left, len(linear.columns))
        scores, information = shared.parts(left)
        of_prior = len(scores) - len(linear.shots)
        return cls(linear.columns, linear.listed, scores, information, settings, of_prior)

    @cached_property
    def total(self) -> Floats:
        """(K, K) information of all shots."""
        total: Floats = self.information.sum(axis=0)
        return total

    @cached_property
    def observable(self) -> NDArray[np.bool_]:
        """(K,) which hypotheses change what is measured at all."""
        diagonal = np.diag(self.total)
        return diagonal > 0.0

    @cached_property
    def free(self) -> tuple[int, ...]:
        """Places of the listed parameters that the shots see."""
        return tuple(np.flatnonzero(self.listed & self.observable).tolist())

    def score_test(self, block: Sequence[int], given: Sequence[int]) -> ScoreTest:
        """Test a block of hypotheses given others that are free."""
        others = [k for k in given if k not in block]
        projection = Projection.of(self.total, self.scores, list(block), others)
        scores = projection.scores(self.scores, self.information)
        shares = projection.information(self.information)
        return ScoreTest(tuple(block), scores, shares, self.settings, self.of_prior)

    def decidable(self, given: Sequence[int], min_size: float | None = None) -> Places:
        """Return the places of hypotheses that the shots can tell from all given ones.

        The least effective sample size is that of a minimum detectable effect if not given.
        """
        return tuple(
            k
            for k in np.flatnonzero(self.observable).tolist()
            if self.decides(self.score_test([k], given), min_size)
        )

    def decides(self, test: ScoreTest, min_size: float | None = None) -> bool:
        """Return whether the shots can decide about the one hypothesis of a test."""
        (k,) = test.block
        settings = self.settings.inference
        least = settings.min_detectable_sample_size if min_size is None else min_size
        information = test.information[0, 0]
        reach = np.ptp(self.columns[k].declaration.bounds)
        identifiable = information > settings.min_information * self.total[k, k]
        within = information * reach**2 > settings.detectable**2
        return bool(identifiable and within and test.effective_sample_size > least)

    def minimum_detectable_effect(self, k: int, given: Sequence[int]) -> float:
        """Return the minimum detectable effect of a hypothesis, in its unit."""
        return self.settings.inference.detectable * float(
            self.score_test([k], given).standard_error[0]
        )


def familywise_p_values(tests: Sequence[ScoreTest]) -> Floats:
    """Return p-values adjusted for the number of tests (Sidak 1967)."""
    p_values = np.array([test.p_value for test in tests])
    of_least: Floats = -np.expm1(len(tests) * np.log1p(-np.minimum(p_values, 1 - 1e-12)))
    return of_least
