"""Name: from shots and a simulator to the causes of the gap between them.

The shots are fitted about the simulator as it is; the linearised evidence for every hypothesis
gives the best explanation (explain.py), whose values are then refitted exactly; about this better
simulator noise, scatter and evidence are taken anew, until the explanation stays. Explanations grow
by a few causes a round, since about a simulator that is far off the evidence for many at once is
poor; every round weighs all sets afresh, so that what stood in for causes not yet known goes again.
What evidence promises has to come true when the shots are refitted: where spins were not measured,
lift is a product of two unknowns, and far from where it is linear a promise may be empty.
Before that, two causes are looked for that hide all others: lift where a simulator has none
(lift.py), and labels that read backwards (signs.py). Labels in doubt are left out until the other
causes are known, and tell which of them are wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.gap.fit.refit import Refitted, gained, refit
from models.gap.fit.shots import Shots, evenly
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.inference.score_test import Evidence
from models.gap.name.label_signs import Signs, no_signs, signs
from models.gap.name.missing_lift import lift
from models.gap.name.selection import (
    AT_ONCE,
    Explainer,
    Explanation,
    explained,
    from_nominal,
)
from models.gap.types import Places

MOST_ROUNDS = 8
MOST_SHOTS = 70  # of which causes are looked for first; all of them only look once more
LEAST_SPIN = 1.0  # rad/s that a component of a spin may always have

# Shots about a simulator with causes in it, the explanation of these, and whether it stays.
Followed = tuple[Refitted, Explainer, Explanation, bool]
# From what weighs explanations about a refit, and places of known causes, to another explanation.
Proposal = Callable[[Explainer, Places], Explanation]

EXTRAPOLATED = 0.01  # of a gain, to which evidence about causes that are far off is good

SIGNS = "spin_sign_flip"
LIFT = Hypothesis("magnus", "cm")


@dataclass(frozen=True)
class Question:
    """What is asked of shots.

    Attributes:
        simulator: that they may contradict.
        level: chance of a false name in a set without any gap.
        withheld: effects of the catalogue that are not in question.
    """

    simulator: Simulator
    level: float
    withheld: tuple[str, ...] = ()


@dataclass(frozen=True)
class Named:
    """What was found.

    Attributes:
        found: the shots about the simulator with the causes in it.
        explainer: weighs explanations about departures from the simulator as it was.
        explanation: the causes.
        settled: whether they stayed when the shots were refitted with them.
        before: the shots about the simulator as it was.
        signs: which labels read backwards.
    """

    found: Refitted
    explainer: Explainer
    explanation: Explanation
    settled: bool
    before: Refitted
    signs: Signs

    @property
    def simulator(self) -> Simulator:
        """The simulator with the estimates of all causes, signs of labels aside."""
        return with_estimates(self.explainer, self.explanation.causes)

    @property
    def spins(self) -> tuple[float, float]:
        """Sizes of a component of a spin, rad/s, by the simulator as it was and with the causes."""
        return _typical_spin(self.before), _typical_spin(self.found)


def name(
    shots: Shots, question: Question, begun: Callable[[Evidence], None] = lambda first: None
) -> Named:
    """Name the causes of the gap between shots and a simulator.

    Args:
        shots: measured.
        question: what is asked of them.
        begun: is told the evidence before causes are looked for.
    """
    base = refit(shots, question.simulator, ())
    begun(from_nominal(base, question.simulator, question.withheld))
    about = _lifted(shots, question) or base
    if SIGNS in question.withheld:
        return _explained(shots, question, about, base, no_signs(shots))
    doubtful = signs(shots, about)
    if doubtful.significant:
        return _in_doubt(shots, question, doubtful)
    named = _explained(shots, question, about, base, doubtful)
    if named.explanation.causes:
        turned = signs(shots, named.found)
        if turned != doubtful:
            named = _resumed(named, turned.righted(shots), question, base, turned)
    return named


def _in_doubt(shots: Shots, question: Question, doubtful: Signs) -> Named:
    """Return the causes by all labels but doubtful ones; these then read as the causes have it.

    A simulator that lacks a cause may mistake signs, and causes that were found with signs put
    wrong would confirm them.
    """
    silent = doubtful.left_out(shots)
    base = refit(silent, question.simulator, ())
    named = _explained(silent, question, _lifted(silent, question) or base, base, doubtful)
    turned = signs(shots, refit(shots, named.simulator, ()))
    righted = turned.righted(shots)
    return _resumed(named, righted, question, refit(righted, question.simulator, ()), turned)


def _resumed(
    named: Named, shots: Shots, question: Question, before: Refitted, turned: Signs
) -> Named:
    """Return the causes where labels have other signs, from where those found before have led."""
    begin = refit(shots, named.simulator, _hypotheses(named.explainer, named.explanation))
    return Named(*_settled(begin, question, ()), before=before, signs=turned)


def with_estimates(explainer: Explainer, causes: Places) -> Simulator:
    """Return the nominal simulator with the likeliest values of some causes within their bounds."""
    simulator, places = explainer.nominal, list(causes)
    if not places:
        return simulator
    scales = explainer.scales
    information, scores = scales.information[np.ix_(places, places)], scales.scores[places]
    unit = 1 / np.sqrt(np.diag(information))
    root = np.linalg.cholesky(information * np.outer(unit, unit))
    low, high = ((scales.bounds[places] - scales.start[places, None]) / unit[:, None]).T
    # One value that meets its bound moves the others, which the shots tie to it.
    changes = unit * lsq_linear(root.T, np.linalg.solve(root, unit * scores), (low, high)).x
    for k, value in zip(places, scales.start[places] + changes, strict=True):
        hypothesis = explainer.evidence.columns[k]
        simulator = hypothesis.at(simulator, float(np.clip(value, *hypothesis.declaration.bounds)))
    return simulator


def _typical_spin(found: Refitted) -> float:
    squares = (found.linear.unknowns[:, SPIN] ** 2).mean(axis=1)
    typical = np.sqrt(np.average(squares, weights=found.components.trust))
    return max(float(typical), LEAST_SPIN)


def _lifted(shots: Shots, question: Question) -> Refitted | None:
    """Return the shots with lift, where spins bend them and the simulator has none."""
    simulator = question.simulator
    if LIFT.effect in (*simulator.effects, *question.withheld):
        return None
    own = tuple(one for one in hypotheses(simulator) if one.listed(simulator))
    found = lift(shots, refit(shots, simulator, own))
    if found.p_value > question.level:
        return None
    # The simulator's own values go back to where they were: they have to earn their change.
    lifted = LIFT.at(simulator, LIFT.value(found.with_lift.simulator))
    return refit(shots, lifted, (LIFT,))


def _explained(
    shots: Shots, question: Question, base: Refitted, before: Refitted, turned: Signs
) -> Named:
    """Explain the shots: where there are many, some of them first, which is most of the way."""
    few = base[evenly(len(shots), MOST_SHOTS)]
    found, explainer, explanation, settled = _settled(few, question, base.free)
    if len(shots) > MOST_SHOTS:
        causes = _hypotheses(explainer, explanation)
        near = with_estimates(explainer, explanation.causes)
        begin = base if causes == base.free else refit(shots, near, causes)
        found, explainer, explanation, settled = _settled(begin, question, base.free)
    return Named(found, explainer, explanation, settled, before, turned)


def _settled(found: Refitted, question: Question, always: tuple[Hypothesis, ...]) -> Followed:
    """Explain and refit in turn until the explanation stays; last comes whether it does.

    Where an explanation breaks its promise, causes are from there on added one at a time to those
    found, as long as promises are kept; then those that are not significant are dropped, as well
    one at a time.

    Args:
        found: shots about a simulator nearby.
        question: what is asked of them.
        always: causes that are known.
    """
    found, explainer, explanation, stays = _followed(found, question, always, _afresh)
    broken = not stays and _hypotheses(explainer, explanation) == found.free
    for propose in (_one_more, _fewer) if broken else ():
        found, explainer, explanation, stays = _followed(found, question, always, propose)
    simpler = _simpler(found, explainer, question, always) if stays else None
    return simpler or (found, explainer, explanation, stays)


def _simpler(
    found: Refitted, explainer: Explainer, question: Question, always: tuple[Hypothesis, ...]
) -> Followed | None:
    """Return an explanation of fewer causes that fits as well, where about these it stays.

    Evidence about causes that are far off is too poor to tell one from two that do its work: a
    clock that runs a fifth slow from a wrong gravity and a spin sensor's gain.
    """
    held, known = explainer.refitted, _places(explainer.evidence, always)
    if len(held) < len(known) + 2:
        return None
    fewer = explained(explainer, known, len(held) - 1).causes
    if explainer.gain(fewer) < (1 - EXTRAPOLATED) * explainer.gain(held):
        return None
    causes = tuple(explainer.evidence.columns[k] for k in fewer)
    trial = refit(found.linear.shots, with_estimates(explainer, fewer), causes, begin=found)
    if gained(found, trial) < -explainer.price * (len(held) - len(fewer)):
        return None
    other = _followed(trial, question, always, _afresh)
    _, _, explanation, stays = other
    return other if stays and len(explanation.causes) < len(held) else None


def _followed(
    found: Refitted, question: Question, always: tuple[Hypothesis, ...], propose: Proposal
) -> Followed:
    """Follow explanations as long as they keep their promises; last comes whether they all did."""
    earlier = [found.free]
    while True:
        evidence = from_nominal(found, question.simulator, question.withheld)
        held = _places(evidence, found.free)
        explainer = Explainer(evidence, question.simulator, question.level, held)
        explanation = propose(explainer, _places(evidence, always))
        causes = _hypotheses(explainer, explanation)
        if causes in earlier or len(earlier) > MOST_ROUNDS:
            return found, explainer, explanation, causes in earlier
        earlier.append(causes)
        trial = _as_promised(explainer, explanation, found)
        if trial is None:
            return found, explainer, explained(explainer, held, len(held)), False
        found = trial


def _afresh(explainer: Explainer, always: Places) -> Explanation:
    return explained(explainer, always, len(explainer.refitted) + AT_ONCE)


def _one_more(explainer: Explainer, always: Places) -> Explanation:
    return explained(explainer, explainer.refitted, len(explainer.refitted) + 1)


def _fewer(explainer: Explainer, always: Places) -> Explanation:
    """Return the explanation without the least significant cause, if there is one that is not."""
    held = explainer.refitted
    whole = explained(explainer, held, len(held))
    weakest = max(set(held) - set(always), key=lambda k: whole.p_values[k], default=None)
    if weakest is None or whole.p_values[weakest] <= explainer.level:
        return whole
    rest = tuple(k for k in held if k != weakest)
    return explained(explainer, rest, len(rest))


def _as_promised(
    explainer: Explainer, explanation: Explanation, found: Refitted
) -> Refitted | None:
    """Return shots refitted with an explanation, if they are as likely as it promised, or likelier.

    All is linear about what was found; far from there a promise may be empty. Where values make
    no sense, as a lift that saturates less than not at all, nothing is promised that could be kept.
    """
    gain = explainer.gain(explanation.causes)
    if gain == -np.inf:
        return None
    near = with_estimates(explainer, explanation.causes)
    causes = _hypotheses(explainer, explanation)
    trial = refit(found.linear.shots, near, causes, begin=found)
    promised = min(gain - explainer.gain(explainer.refitted), 0.0)
    return trial if gained(found, trial) > promised - explainer.price else None


def _places(evidence: Evidence, some: tuple[Hypothesis, ...]) -> Places:
    return tuple(k for k, one in enumerate(evidence.columns) if one in some)


def _hypotheses(explainer: Explainer, explanation: Explanation) -> tuple[Hypothesis, ...]:
    return tuple(explainer.evidence.columns[k] for k in explanation.causes)
