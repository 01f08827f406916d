"""Naming: from shots and a simulator to the causes of the gap between them.

The shots are fitted about the nominal simulator; the linearised evidence for every hypothesis gives
the best explanation (selection.py), whose values are then refitted exactly; about this better
simulator noise, scatter and evidence are estimated again, until the explanation no longer changes.
Explanations grow by a few causes a round, since about a simulator that is far off the evidence for
many at once is poor; every round scores all sets again, so that a substitute for an unknown cause
is dropped once that cause is found. A gain that the linear evidence predicts must be confirmed when
the shots are refitted: without measured spins, lift is a product of two unknowns, and a prediction
far from where it is linear may fail.

Two causes that hide all others are looked for first: lift where a simulator has none
(missing_lift.py), and flipped labels (label_signs.py). Labels in doubt are left out until the other
causes are known and show which of them are wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.gap.fit.refit import RefitResult, likelihood_gain, refit
from models.gap.fit.shots import Shots, spread_evenly
from models.gap.hypotheses import LABEL_SIGNS, Hypothesis, hypotheses
from models.gap.inference.score_test import Evidence
from models.gap.name.label_signs import LabelSigns, find_flipped_labels, no_flipped_labels
from models.gap.name.missing_lift import lift_test
from models.gap.name.selection import (
    Explainer,
    Explanation,
    best_explanation,
    evidence_about,
)
from models.gap.settings import GapSettings
from models.gap.types import Places

# Shots about a simulator with causes in it, the explanation of these, and whether it stays.
Followed = tuple[RefitResult, Explainer, Explanation, bool]
# From what weighs explanations about a refit, and places of known causes, to another explanation.
Proposal = Callable[[Explainer, Places], Explanation]

LIFT = Hypothesis("magnus", "cm")


@dataclass(frozen=True)
class Question:
    """What is asked of shots.

    Attributes:
        simulator: that they may contradict.
        settings: of the workflow, with the level of its tests.
        withheld: effects of the catalogue that are not in question.
    """

    simulator: Simulator
    settings: GapSettings
    withheld: tuple[str, ...] = ()


@dataclass(frozen=True)
class Named:
    """What was found.

    Attributes:
        fit: the shots about the simulator with the causes in it.
        explainer: scores explanations by departures from the nominal simulator.
        explanation: the causes.
        settled: whether they stayed when the shots were refitted with them.
        before: the shots about the nominal simulator.
        signs: which labels are flipped.
    """

    fit: RefitResult
    explainer: Explainer
    explanation: Explanation
    settled: bool
    before: RefitResult
    signs: LabelSigns

    @property
    def simulator(self) -> Simulator:
        """The simulator with the estimates of all causes, signs of labels aside."""
        return with_estimates(self.explainer, self.explanation.causes)

    @property
    def spins(self) -> tuple[float, float]:
        """Sizes of a component of a spin, rad/s, by the simulator as it was and with the causes."""
        least = self.signs.settings.name.min_spin
        return _typical_spin(self.before, least), _typical_spin(self.fit, least)


def name(
    shots: Shots, question: Question, on_start: Callable[[Evidence], None] = lambda first: None
) -> Named:
    """Name the causes of the gap between shots and a simulator.

    Args:
        shots: measured.
        question: what is asked of them.
        on_start: called with the evidence before causes are looked for.
    """
    base = refit(shots, question.simulator, (), question.settings.fit)
    on_start(evidence_about(base, question.simulator, question.settings, question.withheld))
    about = _with_lift(shots, question) or base
    if LABEL_SIGNS.effect in question.withheld:
        return _explained(shots, question, about, base, no_flipped_labels(shots, question.settings))
    doubtful = find_flipped_labels(shots, about, question.settings)
    if doubtful.significant:
        return _in_doubt(shots, question, doubtful)
    named = _explained(shots, question, about, base, doubtful)
    if named.explanation.causes:
        turned = find_flipped_labels(shots, named.fit, question.settings)
        if turned != doubtful:
            named = _resumed(named, turned.corrected(shots), question, base, turned)
    return named


def _in_doubt(shots: Shots, question: Question, doubtful: LabelSigns) -> Named:
    """Return the causes by all labels but doubtful ones; these then read as the causes have it.

    A simulator that lacks a cause may mistake signs, and causes that were found with signs put
    wrong would confirm them.
    """
    silent = doubtful.left_out(shots)
    base = refit(silent, question.simulator, (), question.settings.fit)
    named = _explained(silent, question, _with_lift(silent, question) or base, base, doubtful)
    turned = find_flipped_labels(
        shots, refit(shots, named.simulator, (), question.settings.fit), question.settings
    )
    corrected = turned.corrected(shots)
    return _resumed(
        named,
        corrected,
        question,
        refit(corrected, question.simulator, (), question.settings.fit),
        turned,
    )


def _resumed(
    named: Named, shots: Shots, question: Question, before: RefitResult, turned: LabelSigns
) -> Named:
    """Return the causes where labels have other signs, from where those found before have led."""
    causes = _hypotheses(named.explainer, named.explanation)
    start = refit(shots, named.simulator, causes, question.settings.fit)
    return Named(*_settled(start, question, ()), before=before, signs=turned)


def with_estimates(explainer: Explainer, causes: Places) -> Simulator:
    """Return the nominal simulator with the likeliest values of some causes within their bounds."""
    simulator, places = explainer.nominal, list(causes)
    if not places:
        return simulator
    set_scores = explainer.set_scores
    information, scores = set_scores.information[np.ix_(places, places)], set_scores.scores[places]
    unit = 1 / np.sqrt(np.diag(information))
    root = np.linalg.cholesky(information * np.outer(unit, unit))
    low, high = ((set_scores.bounds[places] - set_scores.start[places, None]) / unit[:, None]).T
    # One value that meets its bound moves the others, which the shots tie to it.
    changes = unit * lsq_linear(root.T, np.linalg.solve(root, unit * scores), (low, high)).x
    for k, value in zip(places, set_scores.start[places] + changes, strict=True):
        hypothesis = explainer.evidence.columns[k]
        simulator = hypothesis.at(simulator, float(np.clip(value, *hypothesis.declaration.bounds)))
    return simulator


def _typical_spin(fit: RefitResult, min_spin: float) -> float:
    squares = (fit.linear.nuisance[:, SPIN] ** 2).mean(axis=1)
    typical = np.sqrt(np.average(squares, weights=fit.noise_estimate.shot_weights))
    return max(float(typical), min_spin)


def _with_lift(shots: Shots, question: Question) -> RefitResult | None:
    """Return the shots with lift, where spins bend them and the simulator has none."""
    simulator, settings = question.simulator, question.settings
    if LIFT.effect in (*simulator.effects, *question.withheld):
        return None
    own = tuple(one for one in hypotheses(simulator) if one.listed(simulator))
    fit = lift_test(shots, refit(shots, simulator, own, settings.fit), settings)
    if fit.p_value > question.settings.level:
        return None
    # The simulator's own values go back to where they were: they have to earn their change.
    lifted = LIFT.at(simulator, LIFT.value(fit.with_lift.simulator))
    return refit(shots, lifted, (LIFT,), settings.fit)


def _explained(
    shots: Shots, question: Question, base: RefitResult, before: RefitResult, turned: LabelSigns
) -> Named:
    """Explain the shots: where there are many, some of them first, which is most of the way."""
    most = question.settings.name.first_shots
    few = base[spread_evenly(len(shots), most)]
    fit, explainer, explanation, settled = _settled(few, question, base.free)
    if len(shots) > most:
        causes = _hypotheses(explainer, explanation)
        near = with_estimates(explainer, explanation.causes)
        start = base if causes == base.free else refit(shots, near, causes, question.settings.fit)
        fit, explainer, explanation, settled = _settled(start, question, base.free)
    return Named(fit, explainer, explanation, settled, before, turned)


def _settled(fit: RefitResult, question: Question, required: tuple[Hypothesis, ...]) -> Followed:
    """Explain and refit in turn until the explanation stays; last comes whether it does.

    Where an explanation breaks its promise, causes are from there on added one at a time to those
    found, as long as promises are kept; then those that are not significant are dropped, as well
    one at a time.

    Args:
        fit: shots about a simulator nearby.
        question: what is asked of them.
        required: causes that are known.
    """
    fit, explainer, explanation, stays = _followed(fit, question, required, _afresh)
    broken = not stays and _hypotheses(explainer, explanation) == fit.free
    for propose in (_one_more, _fewer) if broken else ():
        fit, explainer, explanation, stays = _followed(fit, question, required, propose)
    simpler = _simpler(fit, explainer, question, required) if stays else None
    return simpler or (fit, explainer, explanation, stays)


def _simpler(
    fit: RefitResult, explainer: Explainer, question: Question, required: tuple[Hypothesis, ...]
) -> Followed | None:
    """Return an explanation of fewer causes that fits as well, where about these it stays.

    Evidence about causes that are far off is too poor to tell one from two that do its work: a
    clock that runs a fifth slow from a wrong gravity and a spin sensor's gain.
    """
    held, known = explainer.refitted, _places(explainer.evidence, required)
    if len(held) < len(known) + 2:
        return None
    fewer = best_explanation(explainer, known, len(held) - 1).causes
    if explainer.gain(fewer) < (1 - question.settings.name.extrapolation_error) * explainer.gain(
        held
    ):
        return None
    causes = tuple(explainer.evidence.columns[k] for k in fewer)
    near = with_estimates(explainer, fewer)
    trial = refit(fit.linear.shots, near, causes, question.settings.fit, start=fit)
    if likelihood_gain(fit, trial) < -explainer.penalty * (len(held) - len(fewer)):
        return None
    other = _followed(trial, question, required, _afresh)
    _, _, explanation, stays = other
    return other if stays and len(explanation.causes) < len(held) else None


def _followed(
    fit: RefitResult, question: Question, required: tuple[Hypothesis, ...], propose: Proposal
) -> Followed:
    """Follow explanations as long as they keep their promises; last comes whether they all did."""
    earlier = [fit.free]
    while True:
        evidence = evidence_about(fit, question.simulator, question.settings, question.withheld)
        held = _places(evidence, fit.free)
        explainer = Explainer(evidence, question.simulator, held)
        explanation = propose(explainer, _places(evidence, required))
        causes = _hypotheses(explainer, explanation)
        if causes in earlier or len(earlier) > question.settings.name.max_rounds:
            return fit, explainer, explanation, causes in earlier
        earlier.append(causes)
        trial = _as_promised(explainer, explanation, fit)
        if trial is None:
            return fit, explainer, best_explanation(explainer, held, len(held)), False
        fit = trial


def _afresh(explainer: Explainer, required: Places) -> Explanation:
    return best_explanation(
        explainer, required, len(explainer.refitted) + explainer.settings.growth
    )


def _one_more(explainer: Explainer, required: Places) -> Explanation:
    return best_explanation(explainer, explainer.refitted, len(explainer.refitted) + 1)


def _fewer(explainer: Explainer, required: Places) -> Explanation:
    """Return the explanation without the least significant cause, if there is one that is not."""
    held = explainer.refitted
    whole = best_explanation(explainer, held, len(held))
    weakest = max(set(held) - set(required), key=lambda k: whole.p_values[k], default=None)
    if weakest is None or whole.p_values[weakest] <= explainer.evidence.settings.level:
        return whole
    rest = tuple(k for k in held if k != weakest)
    return best_explanation(explainer, rest, len(rest))


def _as_promised(
    explainer: Explainer, explanation: Explanation, fit: RefitResult
) -> RefitResult | None:
    """Return shots refitted with an explanation, if they are as likely as it promised, or likelier.

    All is linear about what was found; far from there a promise may be empty. Where values make
    no sense, as a lift that saturates less than not at all, nothing is promised that could be kept.
    """
    gain = explainer.gain(explanation.causes)
    if gain == -np.inf:
        return None
    near = with_estimates(explainer, explanation.causes)
    causes = _hypotheses(explainer, explanation)
    trial = refit(fit.linear.shots, near, causes, explainer.evidence.settings.fit, start=fit)
    promised = min(gain - explainer.gain(explainer.refitted), 0.0)
    return trial if likelihood_gain(fit, trial) > promised - explainer.penalty else None


def _places(evidence: Evidence, some: tuple[Hypothesis, ...]) -> Places:
    return tuple(k for k, one in enumerate(evidence.columns) if one in some)


def _hypotheses(explainer: Explainer, explanation: Explanation) -> tuple[Hypothesis, ...]:
    return tuple(explainer.evidence.columns[k] for k in explanation.causes)
