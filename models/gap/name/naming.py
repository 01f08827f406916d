"""Naming: from shots and a simulator to the causes of the gap between them (docs/naming.md).

The best explanation about a fit (selection.py) is refitted exactly, and evidence is evaluated again
about the refitted simulator, until the explanation no longer changes. A refit must confirm the gain
that the linear evidence predicts.

Causes that hide all others come first: lift where a simulator has none and a dead bounce
(first_causes.py), and flipped labels (label_readings.py). Doubtful labels are left out until the
other causes are known.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.refit import RefitResult, likelihood_gain, refit
from rallygap.models.gap.fit.shots import Shots, spread_evenly
from rallygap.models.gap.hypotheses import LABEL_SIGNS, Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.name.distortion import CAMERA, Distortion, find_distortion, with_field
from rallygap.models.gap.name.first_causes import FIRST_CAUSES, about_first_causes
from rallygap.models.gap.name.label_readings import (
    LabelReadings,
    all_as_read,
    read_labels,
    without_labels,
)
from rallygap.models.gap.name.selection import (
    Explainer,
    Explanation,
    best_explanation,
    evidence_about,
)
from rallygap.models.gap.settings import Question
from rallygap.models.gap.types import Places

# Shots refitted with causes, the explanation by these, and whether it is stable.
Followed = tuple[RefitResult, Explainer, Explanation, bool]
# From an explainer about a refit, and places of known causes, to the next explanation.
Proposal = Callable[[Explainer, Places], Explanation]
Causes = tuple[Hypothesis, ...]


@dataclass(frozen=True)
class Named:
    """The causes.

    Attributes:
        fit: the shots about the simulator with the causes in it.
        explainer: scores explanations by departures from the nominal simulator.
        explanation: the causes.
        settled: whether they stayed when the shots were refitted with them.
        before: the shots about the nominal simulator.
        readings: which labels are flipped or outliers.
        distortion: the position-dependent camera error, if shots show one.
    """

    fit: RefitResult
    explainer: Explainer
    explanation: Explanation
    settled: bool
    before: RefitResult
    readings: LabelReadings
    distortion: Distortion | None = None

    @property
    def simulator(self) -> Simulator:
        """The simulator with the estimates of all causes, signs of labels aside."""
        return with_estimates(self.explainer, self.explanation.causes)

    def corrected(self, shots: Shots) -> Shots:
        """Return shots less the position-dependent camera error, if there is one."""
        if self.distortion is None:
            return shots
        with_functions = self.distortion.field.on(shots, shots.positions)
        return with_functions.corrected(self.fit.camera_errors).without_shared()

    @property
    def spins(self) -> tuple[float, float]:
        """Sizes of a component of a spin, rad/s, by the nominal simulator and with the causes."""
        least = self.readings.settings.name.min_spin
        return self.before.typical_spin(least), self.fit.typical_spin(least)


def name(
    shots: Shots, question: Question, on_start: Callable[[Evidence], None] = lambda evidence: None
) -> Named:
    """Name the causes; ``on_start`` gets the evidence before they are searched for.

    Where there are many shots, causes are first searched for on some of them, to save time.
    """
    base = refit(shots, question.simulator, (), question.settings.fit)
    on_start(evidence_about(base, question))
    few = spread_evenly(len(shots), question.settings.name.first_shots)
    named = _of_few(shots[few], question, base[few])
    return named if len(few) == len(shots) else _of_all(named, shots, question, base)


def _of_few(shots: Shots, question: Question, base: RefitResult) -> Named:
    """Name the causes of shots that were fitted about the nominal simulator."""
    alone = _named(shots, question, base)
    named = _with_distortion(alone, question)
    if named is None or _signs_as_read(named, question):
        return named or alone
    # Labels are judged by paths, which an error of the cameras bends.
    about = replace(named.fit.linear.shots, label_times=shots.label_times, labels=shots.labels)
    readings = read_labels(about, named.fit, question.settings)
    if readings == named.readings:
        return named
    alone = _without_doubtful_labels(shots, question, readings)
    return _with_distortion(alone, question) or alone


def _of_all(named: Named, shots: Shots, question: Question, base: RefitResult) -> Named:
    """Name the causes of all shots, starting from those of some of them."""
    settings, causes = question.settings, _hypotheses(named.explainer, named.explanation)
    readings = _readings_of_all(named, shots, question)
    kept = without_labels(shots) if readings.useless else readings.corrected(shots)
    as_read = not readings.useless and not readings.doubtful
    before = base if as_read else refit(kept, question.simulator, (), settings.fit)
    start = refit(kept, named.simulator, causes, settings.fit)
    explainer, explanation = _known_causes(start, question)
    known = Named(start, explainer, explanation, True, before, readings)
    distorted = _with_distortion(known, question)
    return distorted or Named(*_settled(start, question, ()), before, readings)


def _readings_of_all(named: Named, shots: Shots, question: Question) -> LabelReadings:
    """Return how the labels of all shots are read, by the causes of some of them."""
    settings = question.settings
    if _signs_as_read(named, question):
        return replace(all_as_read(shots, settings), useless=named.readings.useless)
    about = refit(shots, named.simulator, (), settings.fit)
    if named.distortion is not None:
        about = with_field(about, named.distortion.field, settings.fit)
    return read_labels(about.linear.shots, about, settings)


def _signs_as_read(named: Named, question: Question) -> bool:
    """Return whether the signs of labels are not in question."""
    return LABEL_SIGNS.effect in question.withheld or named.readings.useless


def _with_distortion(named: Named, question: Question) -> Named | None:
    """Return the causes with a position-dependent camera error; None if shots show none."""
    if CAMERA.effect in question.withheld:
        return None
    found = find_distortion(named.fit, named.explainer)
    return None if found is None else _distorted(named, found, question)


def _distorted(named: Named, found: Distortion, question: Question) -> Named | None:
    """Return the causes refitted together with a position-dependent camera error.

    It is None if the refit makes that error implausibly large.
    """
    settings = question.settings.fit
    fit, before = (with_field(one, found.field, settings) for one in (named.fit, named.before))
    near = with_estimates(named.explainer, found.causes)
    free = tuple(named.explainer.evidence.columns[k] for k in found.causes)
    start = refit(fit.linear.shots, near, free, settings, start=fit)
    fit, explainer, explanation, stays = _settled(start, question, ())
    if not found.is_plausible(fit):
        return None
    return Named(fit, explainer, explanation, stays, before, named.readings, found)


def _named(shots: Shots, question: Question, base: RefitResult) -> Named:
    """Name the causes of shots that were fitted about the nominal simulator."""
    settings = question.settings
    about = about_first_causes(shots, question, base)
    if LABEL_SIGNS.effect in question.withheld:
        return _explained(question, about, base, all_as_read(shots, settings))
    readings = read_labels(shots, about, settings)
    if readings.doubtful:
        return _without_doubtful_labels(shots, question, readings)
    if _useless(base, question):
        return _by_paths(shots, question)
    named = _explained(question, about, base, readings)
    if named.explanation.causes:
        again = read_labels(shots, named.fit, settings)
        if again.doubtful:
            named = _resumed(named, shots, question, again)
    return named


def _without_doubtful_labels(shots: Shots, question: Question, doubtful: LabelReadings) -> Named:
    """Return the causes by all labels but doubtful ones, then by all, corrected by these causes.

    A simulator that lacks a cause may mistake signs, and causes found with wrongly corrected signs
    would confirm them.
    """
    kept = doubtful.left_out(shots)
    base = refit(kept, question.simulator, (), question.settings.fit)
    if _useless(base, question):
        return _by_paths(shots, question)
    named = _explained(question, about_first_causes(kept, question, base), base, doubtful)
    about = refit(shots, named.simulator, (), question.settings.fit)
    return _resumed(named, shots, question, read_labels(shots, about, question.settings))


def _by_paths(shots: Shots, question: Question) -> Named:
    """Return the causes by the paths alone; labels are used if they then agree with the spins.

    Labels that err by more than half of the spin would only mislead. A simulator that lacks a cause
    may make labels look as bad.
    """
    settings, alone = question.settings, without_labels(shots)
    base, none = refit(alone, question.simulator, (), settings.fit), all_as_read(shots, settings)
    unused = replace(none, useless=True)
    named = _explained(question, about_first_causes(alone, question, base), base, unused)
    readings = read_labels(shots, named.fit, settings)
    causes = _hypotheses(named.explainer, named.explanation)
    about = refit(readings.corrected(shots), named.simulator, causes, settings.fit)
    return named if _useless(about, question) else _resumed(named, shots, question, readings)


def _useless(fit: RefitResult, question: Question) -> bool:
    """Return whether labels err by more than the check of them allows (verify/checks.py)."""
    _, most = question.settings.verify.allowed["labels"]
    return bool(fit.linear.labelled.any()) and fit.noise_estimate.noise.label_error > most


def _resumed(named: Named, shots: Shots, question: Question, readings: LabelReadings) -> Named:
    """Return the causes of shots whose labels are read again, starting from earlier causes."""
    shots, settings = readings.corrected(shots), question.settings.fit
    before = refit(shots, question.simulator, (), settings)
    causes = _hypotheses(named.explainer, named.explanation)
    start = refit(shots, named.simulator, causes, settings)
    return Named(*_settled(start, question, ()), before=before, readings=readings)


def without_cause(named: Named, k: int, question: Question) -> Named:
    """Return shots refitted without one of the causes, the others keep or change their values."""
    rest = tuple(j for j in named.explanation.causes if j != k)
    near = with_estimates(named.explainer, rest)
    causes = tuple(named.explainer.evidence.columns[j] for j in rest)
    shots = named.fit.linear.shots
    fit = refit(shots, near, causes, question.settings.fit, start=named.fit)
    explainer, explanation = _known_causes(fit, question)
    return replace(named, fit=fit, explainer=explainer, explanation=explanation)


def _known_causes(fit: RefitResult, question: Question) -> tuple[Explainer, Explanation]:
    """Return the explanation of shots by the causes that they were refitted with."""
    evidence = evidence_about(fit, question)
    places = _places(evidence, fit.free)
    explainer = Explainer(evidence, question.simulator, places)
    return explainer, best_explanation(explainer, places, len(places))


def with_estimates(explainer: Explainer, causes: Places) -> Simulator:
    """Return the nominal simulator with bounded maximum-likelihood values of some causes."""
    simulator, places = explainer.nominal, list(causes)
    if not places:
        return simulator
    set_scores = explainer.set_scores
    information, scores = set_scores.information[np.ix_(places, places)], set_scores.scores[places]
    unit = 1 / np.sqrt(np.diag(information))
    root = np.linalg.cholesky(information * np.outer(unit, unit))
    low, high = ((set_scores.bounds[places] - set_scores.start[places, None]) / unit[:, None]).T
    # A value at its bound changes the others, which the shots tie to it.
    changes = unit * lsq_linear(root.T, np.linalg.solve(root, unit * scores), (low, high)).x
    for k, value in zip(places, set_scores.start[places] + changes, strict=True):
        hypothesis = explainer.evidence.columns[k]
        simulator = hypothesis.at(simulator, float(np.clip(value, *hypothesis.declaration.bounds)))
    return simulator


def _explained(
    question: Question, about: RefitResult, before: RefitResult, readings: LabelReadings
) -> Named:
    """Explain shots by what they need beyond the simulator that they were fitted about."""
    first = tuple(one for one in about.free if one in FIRST_CAUSES)
    return Named(*_settled(about, question, first), before, readings)


def _settled(fit: RefitResult, question: Question, required: Causes) -> Followed:
    """Explain and refit in turn until the explanation stays; last comes whether it does.

    Where a refit does not confirm an explanation, causes are from there on added one at a time, as
    long as refits confirm them; then those that are not significant are dropped one at a time.
    """
    fit, explainer, explanation, stays = _followed(fit, question, required, _all_again)
    broken = not stays and _hypotheses(explainer, explanation) == fit.free
    for propose in (_one_more, _fewer) if broken else ():
        fit, explainer, explanation, stays = _followed(fit, question, required, propose)
    simpler = _simpler(fit, explainer, question, required) if stays else None
    return simpler or (fit, explainer, explanation, stays)


def _simpler(
    fit: RefitResult, explainer: Explainer, question: Question, required: Causes
) -> Followed | None:
    """Return a stable explanation of fewer causes that fits as well.

    Evidence about causes that are far off is too poor to tell one from two that have the same
    effect: a clock that runs a fifth slow from a wrong gravity and a spin sensor's gain.
    """
    held, known = explainer.refitted, _places(explainer.evidence, required)
    if len(held) < len(known) + 2:
        return None
    fewer = best_explanation(explainer, known, len(held) - 1).causes
    least = (1 - question.settings.name.extrapolation_error) * explainer.gain(held)
    if explainer.gain(fewer) < least:
        return None
    causes = tuple(explainer.evidence.columns[k] for k in fewer)
    near = with_estimates(explainer, fewer)
    trial = refit(fit.linear.shots, near, causes, question.settings.fit, start=fit)
    if likelihood_gain(fit, trial) < -explainer.penalty * (len(held) - len(fewer)):
        return None
    other = _followed(trial, question, required, _all_again)
    _, _, explanation, stays = other
    return other if stays and len(explanation.causes) < len(held) else None


def _followed(
    fit: RefitResult, question: Question, required: Causes, propose: Proposal
) -> Followed:
    """Refit with one proposal after the other as long as refits confirm them.

    Causes that shots do not fit without, though the linear evidence says so, are required then:
    that is of little use where the effect of a cause is far from linear, as that of saturation.
    """
    earlier = [fit.free]
    while True:
        evidence = evidence_about(fit, question)
        held = _places(evidence, fit.free)
        explainer = Explainer(evidence, question.simulator, held)
        explanation = propose(explainer, _places(evidence, required))
        causes = _hypotheses(explainer, explanation)
        if causes in earlier or len(earlier) > question.settings.name.max_rounds:
            return fit, explainer, explanation, causes in earlier
        earlier.append(causes)
        trial = _confirmed(explainer, explanation, fit)
        if trial is None and set(causes) < set(fit.free):
            required = (*required, *(cause for cause in fit.free if cause not in causes))
            continue
        if trial is None:
            return fit, explainer, best_explanation(explainer, held, len(held)), False
        fit = trial


def _all_again(explainer: Explainer, required: Places) -> Explanation:
    most = len(explainer.refitted) + explainer.settings.growth
    return best_explanation(explainer, required, most)


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


def _confirmed(
    explainer: Explainer, explanation: Explanation, fit: RefitResult
) -> RefitResult | None:
    """Return shots refitted with an explanation, if they are as likely as predicted, or likelier.

    The prediction is linear about ``fit``; far from there it may fail. Implausible values, as a
    negative saturation of lift, predict no gain that a refit could confirm.
    """
    gain = explainer.gain(explanation.causes)
    if gain == -np.inf:
        return None
    near = with_estimates(explainer, explanation.causes)
    causes = _hypotheses(explainer, explanation)
    trial = refit(fit.linear.shots, near, causes, explainer.evidence.settings.fit, start=fit)
    predicted = min(gain - explainer.gain(explainer.refitted), 0.0)
    return trial if likelihood_gain(fit, trial) > predicted - explainer.penalty else None


def _places(evidence: Evidence, causes: Causes) -> Places:
    return tuple(k for k, column in enumerate(evidence.columns) if column in causes)


def _hypotheses(explainer: Explainer, explanation: Explanation) -> Causes:
    return tuple(explainer.evidence.columns[k] for k in explanation.causes)
