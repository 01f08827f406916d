"""Variation: parameters that change over the session, or differ from shot to shot.

With the causes in the simulator, each shot has an efficient score about a parameter, and its
information. A drift makes the scores grow along the session: a score test of the slope. Differences
from shot to shot make them spread more than their information says: a likelihood ratio of a
variance, as for shared errors (fit/shared_errors.py). Only parameters of the flight are tested for
differences: those of a contact are its scatter, which the noise has. A variation is no constant
that a simulator could have, so nothing is amended.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import norm

from models.ball.types import Floats
from models.gap.fit.projection import eliminate_nuisance
from models.gap.fit.shared_errors import VarianceLikelihood, variance_p_value
from models.gap.hypotheses import Hypothesis
from models.gap.name.naming import Named
from models.gap.name.parts import phase_of
from models.gap.settings import GapSettings
from models.gap.verdict import Variation


def variations(named: Named) -> tuple[Variation, ...]:
    """Return the surest drift, or without one the surest difference from shot to shot."""
    trends, settings = _trends(named), named.explainer.evidence.settings
    in_flight = [one for one in trends if phase_of(one.hypothesis) == "flight"]
    drifts = tuple(_surest(trends, "drift", settings))
    return drifts or tuple(_surest(in_flight, "between_shots", settings))


def _trends(named: Named) -> list["_Trend"]:
    """Return how shots vary, for each parameter about which they can decide.

    All other parameters, and shared errors, are as estimated.
    """
    evidence, linear = named.explainer.evidence, named.fit.linear
    system = eliminate_nuisance(named.fit.noise_estimate.gram_matrices, linear.nuisance_count)
    across = system.information[:, :, len(linear.columns) :]
    scores = system.scores - across @ named.fit.camera_errors
    information = np.einsum("bkk->bk", system.information)

    def trend(hypothesis: Hypothesis, listed: bool) -> _Trend:
        k = linear.columns.index(hypothesis)
        return _Trend(hypothesis, scores[:, k], information[:, k], listed, evidence.settings)

    given = sorted({*evidence.free, *named.explanation.causes})
    decided = evidence.decidable(given, evidence.settings.name.min_sample_size)
    return [trend(evidence.columns[k], bool(evidence.listed[k])) for k in decided]


@dataclass(frozen=True, eq=False)
class _Trend:
    """How the scores of B shots about one parameter vary.

    Attributes:
        hypothesis: the parameter.
        raw_scores: (B,) about the value that it has.
        information: (B,) of the shots.
        listed: whether the simulator has it.
        settings: of the workflow.
    """

    hypothesis: Hypothesis
    raw_scores: Floats
    information: Floats
    listed: bool
    settings: GapSettings

    @property
    def scores(self) -> Floats:
        """(B,) of the shots, about the value that all of them together have."""
        estimate = self.raw_scores.sum() / self.information.sum()
        scores: Floats = self.raw_scores - self.information * estimate
        return scores

    @property
    def identity(self) -> str:
        """Of the parameter."""
        return self.hypothesis.identity

    def gain(self, kind: str) -> float:
        """Return twice the gain of log likelihood by a drift, or by differences between shots."""
        size, error, _ = self._drift
        return (size / error) ** 2 if kind == "drift" else self._between.gain

    def p_value(self, kind: str) -> float:
        """Return the p-value of a drift, or of differences from shot to shot."""
        return self._drift[2] if kind == "drift" else self._p_value_between

    def variation(self, kind: str, others: tuple[str, ...]) -> Variation:
        """Return a drift, from the first shot to the last, or differences, a standard deviation."""
        size, error, p_value = self._drift
        quantile = self.settings.normal_quantile
        interval = (size - quantile * error, size + quantile * error)
        if kind == "between_shots":
            size, p_value = self._between.estimate, self._p_value_between
            interval = self._between.interval(self.settings.confidence)
        return Variation.model_validate(
            {
                "identity": self.identity,
                "kind": kind,
                "unit": self.hypothesis.declaration.unit,
                "size": size,
                "interval": interval,
                "p_value": p_value,
                "possible": (self.identity, *others),
            }
        )

    @cached_property
    def _drift(self) -> tuple[float, float, float]:
        """Return the change over the session, its standard error and its p-value."""
        weight = self.information
        order = np.linspace(-0.5, 0.5, len(weight))
        order = order - np.average(order, weights=weight)
        information = float(weight @ order**2)
        size = float(order @ self.scores) / information
        # By the spread of the shots where it is larger than their information says.
        spread = float(order**2 @ (self.scores - weight * size * order) ** 2)
        error = float(np.sqrt(max(spread, information))) / information
        return size, error, float(2 * norm.sf(abs(size) / error))

    @cached_property
    def _between(self) -> VarianceLikelihood:
        return self._likelihood(self.scores)

    @cached_property
    def _p_value_between(self) -> float:
        """A shot whose score is out of line must not decide alone."""
        root = np.sqrt(self.information)
        most = float(norm.isf(self.settings.level / len(root))) * root
        return variance_p_value(self._likelihood(np.clip(self.scores, -most, most)).gain)

    def _likelihood(self, scores: Floats) -> VarianceLikelihood:
        reach = float(np.ptp(self.hypothesis.declaration.bounds))
        return VarianceLikelihood(self.information, scores, (1e-6 * reach, reach))


def _surest(trends: list[_Trend], kind: str, settings: GapSettings) -> Iterator[Variation]:
    """Yield the likeliest variation, if it is significant among all parameters.

    One of the simulator's own parameters is preferred to a missing effect that is about as likely.
    """
    gains = {trend: trend.gain(kind) for trend in trends}
    least = max(gains.values(), default=0.0) - settings.tolerance
    close = [trend for trend in sorted(trends, key=lambda one: -gains[one]) if gains[trend] > least]
    for likeliest in sorted(close, key=lambda trend: not trend.listed)[:1]:
        if likeliest.p_value(kind) <= settings.level / (2 * len(trends)):
            others = tuple(trend.identity for trend in close if trend is not likeliest)
            yield likeliest.variation(kind, others)
