"""From named causes to the parts of a verdict: estimates, shares and detection limits."""

from dataclasses import dataclass, replace

import numpy as np

from models.ball.simulator import Simulator
from models.gap.fit.shot_fit import refit_shots
from models.gap.hypotheses import LABEL_SIGNS, Hypothesis
from models.gap.inference.score_test import Evidence
from models.gap.name.gap_share import shares
from models.gap.name.intervals import within
from models.gap.name.label_signs import LabelSigns
from models.gap.name.naming import Named
from models.gap.name.unexplained import UnexplainedStructure
from models.gap.settings import Question
from models.gap.verdict import Answer, Cause, DetectionLimits, Unexplained


@dataclass(frozen=True)
class GapShares:
    """Shares of the gap, which sum to one where there is a gap.

    Attributes:
        causes: share of each cause, by its place among the hypotheses.
        label_signs: of spin labels with the wrong sign.
        unexplained: of structure that no cause explains.
    """

    causes: dict[int, float]
    label_signs: float
    unexplained: float

    @classmethod
    def of(cls, named: Named, structure: UnexplainedStructure | None) -> "GapShares":
        """Return the shares of causes and significant structure in the likelihood gain."""
        gains = shares(named.explainer.set_scores, named.explanation.causes)
        signs, unexplained = _gain_of_signs(named), structure.test.gain if structure else 0.0
        whole = max(sum(gains.values()) + signs, 1e-12) + unexplained
        parts = {k: gain / whole for k, gain in gains.items()}
        return cls(parts, signs / whole, unexplained / whole)


def causes(named: Named, gap_shares: GapShares) -> tuple[Cause, ...]:
    """Return the causes, the largest share first."""
    found = [_cause(named, k, share) for k, share in gap_shares.causes.items()]
    if named.signs.significant:
        found.append(_label_signs(named, gap_shares.label_signs))
    return tuple(sorted(found, key=lambda cause: -cause.gap_share))


def unexplained(
    structure: UnexplainedStructure, significant: bool, gap_shares: GapShares
) -> Unexplained:
    """Return the part of a verdict about structure that no cause explains."""
    return Unexplained(
        share=gap_shares.unexplained,
        p_value=structure.p_value,
        phase=structure.phase if significant else None,
        formula=structure.candidate_formula if significant else None,
    )


def answer(found: tuple[Cause, ...], significant: bool, settled: bool) -> Answer:
    """Return the verdict in one word, by causes and whether structure beyond is significant."""
    if significant:
        return "unknown"
    if not found:
        return "no_gap"
    return "named" if settled and not any(cause.ambiguous for cause in found) else "ambiguous"


def detection_limits(evidence: Evidence, labels: LabelSigns, question: Question) -> DetectionLimits:
    """Return the detection limits, by evidence about the nominal simulator, listed ones free."""
    free = evidence.free
    sizes = {
        evidence.columns[k].identity: evidence.minimum_detectable_effect(k, free)
        for k in evidence.decidable(free)
    }
    if labels.labelled and LABEL_SIGNS.effect not in question.withheld:
        sizes[LABEL_SIGNS.identity] = labels.detectable
    identities = (column.identity for column in evidence.columns)
    return DetectionLimits(sizes, tuple(one for one in identities if one not in sizes))


def _cause(named: Named, k: int, share: float) -> Cause:
    explainer, places = named.explainer, named.explanation.causes
    evidence, hypothesis = explainer.evidence, explainer.evidence.columns[k]
    test = evidence.score_test([k], [j for j in places if j != k])
    value = hypothesis.value(explainer.nominal) + float(test.estimate[0])
    estimate, interval = within(
        value, float(test.margin[0]), hypothesis.declaration.bounds, evidence.settings
    )
    return _described(
        hypothesis,
        explainer.nominal,
        estimate=estimate,
        interval=interval,
        p_value=named.explanation.p_values[k],
        gap_share=share,
        possible=tuple(evidence.columns[j].identity for j in explainer.alternatives(k, places)),
    )


def _label_signs(named: Named, share: float) -> Cause:
    return _described(
        LABEL_SIGNS,
        named.explainer.nominal,
        estimate=named.signs.share,
        interval=named.signs.interval,
        p_value=0.0,
        gap_share=share,
        possible=(LABEL_SIGNS.identity,),
    )


def _described(hypothesis: Hypothesis, nominal: Simulator, **numbers: object) -> Cause:
    content = {
        "identity": hypothesis.identity,
        "kind": "wrong_value" if hypothesis.listed(nominal) else "missing_effect",
        "unit": hypothesis.declaration.unit,
        "nominal": hypothesis.value(nominal),
        **numbers,
    }
    return Cause.model_validate(content)


def _gain_of_signs(named: Named) -> float:
    """Return the gain of twice the log likelihood when the wrong label signs are corrected."""
    if not named.signs.significant:
        return 0.0
    fit, settings = named.fit, named.signs.settings.fit
    rows = np.array(sorted(named.signs.flipped))
    corrected, nuisance = fit.corrected_shots[rows], fit.linear.nuisance[rows]
    as_read = replace(corrected, labels=-corrected.labels)
    costs = [
        refit_shots(shots, fit.simulator, nuisance, fit.noise_estimate.noise, settings).cost.sum()
        for shots in (as_read, corrected)
    ]
    return max(float(costs[0] - costs[1]), 0.0)
