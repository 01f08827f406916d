"""Variation: parameters that drift, or differ between sides of the net or between shots.

With the causes in the simulator, each shot has an efficient score about a parameter, and its
information. A drift makes the scores grow along the session: a score test of the slope. Differences
from shot to shot make them spread more than their information says: a likelihood ratio of a
variance, as for shared errors (fit/shared_errors.py). Differences between the sides of the net are
tested in by_side.py. Only parameters of the flight are tested for differences: those of a contact
from shot to shot are its scatter, which the noise has, and those by place are unexplained
structure. A variation is no constant that a simulator could have, so nothing is amended.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, get_args

import numpy as np
from scipy.stats import norm

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.projection import eliminate_nuisance
from rallygap.models.gap.fit.shared_errors import VarianceLikelihood, variance_p_value
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import ScoreTest
from rallygap.models.gap.name.by_side import side_tests
from rallygap.models.gap.name.naming import Named
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Variation, VariationKind

KINDS = len(get_args(VariationKind))  # each is tested for every parameter


def variations(named: Named) -> tuple[Variation, ...]:
    """Return the variation of the first kind that is significant; empty without any.

    The kinds are tested in this order: drift, difference between the sides of the net, difference
    between shots. Of a kind, the most significant parameter is returned.
    """
    trends, settings = _trends(named), named.explainer.evidence.settings
    in_flight = [one for one in trends if one.hypothesis.phase == "flight"]
    return (
        tuple(_surest(trends, "drift", settings))
        or tuple(_surest(in_flight, "by_side", settings))
        or tuple(_surest(in_flight, "between_shots", settings))
    )


def _trends(named: Named) -> list["_Trend"]:
    """Return how shots vary, for each parameter about which they can decide.

    All other parameters, and shared errors, are as estimated.
    """
    evidence, linear = named.explainer.evidence, named.fit.linear
    system = eliminate_nuisance(named.fit.noise_estimate.gram_matrices, linear.nuisance_count)
    across = system.information[:, :, len(linear.columns) :]
    scores = system.scores - across @ named.fit.camera_errors
    information = np.einsum("bkk->bk", system.information)

    given = sorted({*evidence.free, *named.explanation.causes})
    sides = side_tests(named.fit, [evidence.columns[k] for k in given], evidence.settings)

    def trend(hypothesis: Hypothesis, listed: bool) -> _Trend:
        k = linear.columns.index(hypothesis)
        side = sides.get(hypothesis)
        return _Trend(hypothesis, scores[:, k], information[:, k], listed, side, evidence.settings)

    decided = evidence.decidable(given, evidence.settings.name.min_sample_size)
    return [trend(evidence.columns[k], bool(evidence.listed[k])) for k in decided]


class _Tested(NamedTuple):
    """A variation of one kind.

    Attributes:
        gain: twice that of log likelihood.
        p_value: of so much without any.
        size: from the first shot to the last, from y < 0 to y > 0, or a standard deviation.
        interval: of the size.
    """

    gain: float
    p_value: float
    size: float
    interval: tuple[float, float]


@dataclass(frozen=True, eq=False)
class _Trend:
    """How the scores of B shots about one parameter vary.

    Attributes:
        hypothesis: the parameter.
        raw_scores: (B,) about the value that it has.
        information: (B,) of the shots.
        listed: whether the simulator has it.
        side: test of its difference between the sides of the net; None where shots do not decide.
        settings: of the workflow.
    """

    hypothesis: Hypothesis
    raw_scores: Floats
    information: Floats
    listed: bool
    side: ScoreTest | None
    settings: GapSettings

    @property
    def scores(self) -> Floats:
        """(B,) of the shots, about the value that all of them together have."""
        estimate = self.raw_scores.sum() / self.information.sum()
        scores: Floats = self.raw_scores - self.information * estimate
        return scores

    def tested(self, kind: VariationKind) -> _Tested | None:
        """Return a variation of this kind, significant or not; None where shots do not decide."""
        if kind == "drift":
            return self._drift
        return self._by_side if kind == "by_side" else self._between_shots

    def variation(self, kind: VariationKind, tested: _Tested, others: tuple[str, ...]) -> Variation:
        """Return the part of the verdict about a variation."""
        identity = self.hypothesis.identity
        return Variation(
            identity=identity,
            kind=kind,
            unit=self.hypothesis.declaration.unit,
            size=tested.size,
            interval=tested.interval,
            p_value=tested.p_value,
            possible=(identity, *others),
        )

    @cached_property
    def _drift(self) -> _Tested:
        weight = self.information
        order = np.linspace(-0.5, 0.5, len(weight))
        order = order - np.average(order, weights=weight)
        information = float(weight @ order**2)
        size = float(order @ self.scores) / information
        # By the spread of the shots where it is larger than their information says.
        spread = float(order**2 @ (self.scores - weight * size * order) ** 2)
        error = float(np.sqrt(max(spread, information))) / information
        ratio, margin = abs(size) / error, self.settings.normal_quantile * error
        return _Tested(ratio**2, float(2 * norm.sf(ratio)), size, (size - margin, size + margin))

    @cached_property
    def _by_side(self) -> _Tested | None:
        if self.side is None:
            return None
        size, margin = float(self.side.estimate[0]), float(self.side.margin[0])
        return _Tested(self.side.gain, self.side.p_value, size, (size - margin, size + margin))

    @cached_property
    def _between_shots(self) -> _Tested:
        """A shot whose score is out of line must not decide alone."""
        root = np.sqrt(self.information)
        most = float(norm.isf(self.settings.level / len(root))) * root
        p_value = variance_p_value(self._likelihood(np.clip(self.scores, -most, most)).gain)
        found = self._likelihood(self.scores)
        return _Tested(
            found.gain, p_value, found.estimate, found.interval(self.settings.confidence)
        )

    def _likelihood(self, scores: Floats) -> VarianceLikelihood:
        reach = float(np.ptp(self.hypothesis.declaration.bounds))
        return VarianceLikelihood(self.information, scores, (1e-6 * reach, reach))


def _surest(
    trends: list[_Trend], kind: VariationKind, settings: GapSettings
) -> Iterator[Variation]:
    """Yield the most likely variation, if it is significant among all parameters.

    One of the simulator's own parameters is preferred to a missing effect that is about as likely.
    """
    found = {trend: tested for trend in trends if (tested := trend.tested(kind)) is not None}
    least = max((one.gain for one in found.values()), default=0.0) - settings.tolerance
    close = sorted(found, key=lambda trend: -found[trend].gain)
    close = [trend for trend in close if found[trend].gain > least]
    for likeliest in sorted(close, key=lambda trend: not trend.listed)[:1]:
        if found[likeliest].p_value <= settings.level / (KINDS * len(found)):
            others = tuple(one.hypothesis.identity for one in close if one is not likeliest)
            yield likeliest.variation(kind, found[likeliest], others)
