"""Name: from shots and a simulator to the causes of the gap between them.

The shots are fitted about the simulator as it is; the linearised evidence for every hypothesis
gives the best explanation (explain.py), whose values are then refitted exactly; about this better
simulator noise, scatter and evidence are taken anew, until the explanation stays. Explanations grow
by a few causes a round, since about a simulator that is far off the evidence for many at once is
poor; every round weighs all sets afresh, so that what stood in for causes not yet known goes again.
Before that, two causes that have no derivative are looked for: labels that read backwards
(signs.py), and lift where no spin was measured (lift.py).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.gap.evidence import Evidence
from models.gap.explain import AT_ONCE, Explainer, Explanation, Places, explained, from_nominal
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.lift import lift
from models.gap.refit import Refitted, refit
from models.gap.shots import Shots, evenly
from models.gap.signs import Signs, no_signs, signs

MOST_ROUNDS = 8
MOST_SHOTS = 70  # of which causes are looked for first; all of them only look once more

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
        first: the evidence before causes were looked for.
        signs: which labels read backwards.
    """

    found: Refitted
    explainer: Explainer
    explanation: Explanation
    settled: bool
    first: Evidence
    signs: Signs

    @property
    def simulator(self) -> Simulator:
        """The simulator with the estimates of all causes, signs of labels aside."""
        return with_estimates(self.explainer, self.explanation.causes)


def name(
    shots: Shots, question: Question, begun: Callable[[Evidence], None] = lambda first: None
) -> Named:
    """Name the causes of the gap between shots and a simulator.

    Args:
        shots: measured.
        question: what is asked of them.
        begun: is told the evidence before causes are looked for.
    """
    base, turned = refit(shots, question.simulator, ()), no_signs(shots)
    as_read = from_nominal(base, question.simulator, question.withheld)
    begun(as_read)
    if SIGNS not in question.withheld:
        turned = signs(shots, base)
    named = _with_signs(shots, question, turned, None if turned.significant else base)
    # A simulator that lacks a cause may mistake signs; the one that has it decides.
    if SIGNS not in question.withheld and named.explanation.causes:
        again = turned.corrected(signs(turned.righted(shots), named.found))
        if again != turned:
            first = named.first if again.significant else as_read
            named = _resumed(named, again.righted(shots), question, first, again)
    return named


def _with_signs(shots: Shots, question: Question, turned: Signs, base: Refitted | None) -> Named:
    shots = turned.righted(shots)
    base = base or refit(shots, question.simulator, ())
    first = from_nominal(base, question.simulator, question.withheld)
    return _explained(shots, question, _lifted(shots, question) or base, first, turned)


def _resumed(
    named: Named, shots: Shots, question: Question, first: Evidence, turned: Signs
) -> Named:
    """Return the causes where labels have other signs, from where those found before have led."""
    begin = refit(shots, named.simulator, _hypotheses(named.explainer, named.explanation))
    return Named(*_settled(begin, question, ()), first=first, signs=turned)


def with_estimates(explainer: Explainer, causes: Places) -> Simulator:
    """Return the nominal simulator with the estimates of some causes, within their bounds."""
    simulator = explainer.nominal
    if causes:
        _, estimates = explainer.scales.gains(np.array([causes]))
        for k, change in zip(causes, estimates[0], strict=True):
            hypothesis = explainer.evidence.columns[k]
            value = hypothesis.value(explainer.nominal) + float(change)
            bounded = float(np.clip(value, *hypothesis.declaration.bounds))
            simulator = hypothesis.at(simulator, bounded)
    return simulator


def _lifted(shots: Shots, question: Question) -> Refitted | None:
    """Return the shots with lift, where unlabelled spins bend them and the simulator has none."""
    simulator = question.simulator
    known = LIFT.effect in (*simulator.effects, *question.withheld)
    if known or shots.labelled.any():
        return None
    own = tuple(one for one in hypotheses(simulator) if one.listed(simulator))
    found = lift(shots, refit(shots, simulator, own))
    if found.p_value > question.level:
        return None
    # The simulator's own values go back to where they were: they have to earn their change.
    lifted = LIFT.at(simulator, LIFT.value(found.with_lift.simulator))
    return refit(shots, lifted, (LIFT,))


def _explained(
    shots: Shots, question: Question, base: Refitted, first: Evidence, turned: Signs
) -> Named:
    """Explain the shots: where there are many, some of them first, which is most of the way."""
    few = base[evenly(len(shots), MOST_SHOTS)]
    found, explainer, explanation, settled = _settled(few, question, base.free)
    if len(shots) > MOST_SHOTS:
        causes = _hypotheses(explainer, explanation)
        near = with_estimates(explainer, explanation.causes)
        begin = base if causes == base.free else refit(shots, near, causes)
        found, explainer, explanation, settled = _settled(begin, question, base.free)
    return Named(found, explainer, explanation, settled, first, turned)


def _settled(
    found: Refitted, question: Question, always: tuple[Hypothesis, ...]
) -> tuple[Refitted, Explainer, Explanation, bool]:
    """Explain and refit in turn until the explanation stays; last comes whether it does.

    Args:
        found: shots about a simulator nearby.
        question: what is asked of them.
        always: causes that are known.
    """
    earlier = [found.free]
    while True:
        evidence = from_nominal(found, question.simulator, question.withheld)
        explainer = Explainer(evidence, question.simulator, question.level)
        known = tuple(k for k, one in enumerate(evidence.columns) if one in always)
        explanation = explained(explainer, known, len(found.free) + AT_ONCE)
        causes = _hypotheses(explainer, explanation)
        if causes in earlier or len(earlier) > MOST_ROUNDS:
            return found, explainer, explanation, causes in earlier
        earlier.append(causes)
        near = with_estimates(explainer, explanation.causes)
        found = refit(found.linear.shots, near, causes, begin=found)


def _hypotheses(explainer: Explainer, explanation: Explanation) -> tuple[Hypothesis, ...]:
    return tuple(explainer.evidence.columns[k] for k in explanation.causes)
