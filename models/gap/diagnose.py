"""Diagnose: from shots and a simulator to a verdict."""

import itertools
from collections.abc import Sequence
from math import factorial

import numpy as np

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.gap.evidence import Evidence
from models.gap.explain import Explainer, Places
from models.gap.limits import limits
from models.gap.name import SIGNS, Named, Question, name
from models.gap.refit import fitted
from models.gap.shots import Shots
from models.gap.signs import Signs, signs
from models.gap.unknown import PHASES, Leftover, Phase, leftover
from models.gap.verdict import (
    Answer,
    Cause,
    Unexplained,
    Verdict,
    Where,
    component_of,
    label_of,
    name_of,
)
from models.gap.verify import errors, gap

LEVEL = 0.003
HELD_OUT = 3  # one shot in so many
INTERVAL = 1.96  # standard errors
PHASE_OF: dict[str, Phase] = {"flight": "flight", "contact": "table", "sensor": "sensor"}


def diagnose(
    shots: Shots, simulator: Simulator, level: float = LEVEL, withheld: Sequence[str] = ()
) -> Verdict:
    """Say where shots and a simulator disagree, and why.

    Two shots in three serve for naming, by recordings where there are several; the rest judge the
    names and show how far the gap closes.

    Args:
        shots: measured.
        simulator: to compare with.
        level: chance of a false name in a set without any gap.
        withheld: effects of the catalogue that are not in question.

    Raises:
        ValueError: there are fewer than three shots.
    """
    if len(shots) < HELD_OUT:
        raise ValueError(f"{len(shots)} shots are too few; give at least {HELD_OUT}")
    question = Question(simulator, level, tuple(withheld))
    held = held_out(shots)
    named = name(shots[~held], question)
    noise, fresh = named.found.components.noise, shots[held]
    about = fitted(fresh, named.found.simulator, noise)
    if named.signs.significant:
        fresh = signs(fresh, about).righted(fresh)
        about = fitted(fresh, named.found.simulator, noise)
    left = leftover(named.found, question.withheld)
    found = left.p_value <= level and left.confirmed(about, question.withheld)
    verdict = _verdict(named, left if found else None, left.p_value, shots, question)
    after = errors(about, simulator, named.simulator, noise, _typical_spin(named))
    return verdict.model_copy(update={"gap": gap(after)})


def held_out(shots: Shots) -> np.ndarray:
    """Return (B,) which shots are kept from naming: whole recordings where there are several."""
    groups, member = np.unique(shots.groups.astype(str), return_inverse=True)
    units = member if len(groups) >= 2 * HELD_OUT else np.arange(len(shots))
    order = np.random.default_rng(0).permutation(units.max() + 1)
    return np.asarray(order[units] % HELD_OUT == 0)


def detectable(evidence: Evidence) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the smallest size of every number that shots would show, and what they are blind to.

    Args:
        evidence: of the shots, before causes are looked for.
    """
    told = evidence.decidable(evidence.free)
    sizes = {label_of(evidence.columns[k]): evidence.detectable(k, evidence.free) for k in told}
    return sizes, tuple(label_of(one) for one in evidence.columns if label_of(one) not in sizes)


def _typical_spin(named: Named) -> float:
    """Return the typical component of the spins that shots had, rad/s."""
    spins = named.found.linear.unknowns[:, SPIN]
    return float(np.median(np.linalg.norm(spins, axis=1)) / np.sqrt(3.0))


def _verdict(
    named: Named, left: Leftover | None, p_value: float, shots: Shots, question: Question
) -> Verdict:
    explained = named.explainer.gain(named.explanation.causes)
    whole = max(explained + (left.gain if left else 0.0), 1e-12)
    causes = [*_causes(named, whole), *_signs(named.signs)]
    sizes, blind = detectable(named.first)
    if named.signs.labelled and SIGNS not in question.withheld:
        sizes[SIGNS] = named.signs.detectable
        blind = tuple(one for one in blind if one != SIGNS)
    unexplained = Unexplained(
        share=left.gain / whole if left else 0.0,
        p_value=p_value,
        where=left.where if left else None,
        lead=left.lead if left else None,
    )
    return Verdict(
        verdict=_answer(causes, left is not None),
        effects=tuple(causes),
        unexplained=unexplained,
        where=_where(causes, left, unexplained.share),
        gap=None,
        detectable=sizes,
        blind_to=blind,
        limits=limits(shots, causes, blind),
    )


def _answer(causes: Sequence[Cause], unknown: bool) -> Answer:
    if unknown:
        return "unknown"
    if not causes:
        return "no_gap"
    return "ambiguous" if any(len(one.possible) > 1 for one in causes) else "named"


def _causes(named: Named, whole: float) -> list[Cause]:
    explainer, places = named.explainer, named.explanation.causes
    shares = _shapley(explainer, places)
    return [_cause(named, k, places, shares[k] / whole) for k in places]


def _cause(named: Named, k: int, causes: Places, share: float) -> Cause:
    explainer = named.explainer
    evidence, hypothesis = explainer.evidence, explainer.evidence.columns[k]
    test = evidence.tested([k], [one for one in causes if one != k])
    nominal = hypothesis.value(explainer.nominal)
    estimate, error = nominal + float(test.estimate[0]), INTERVAL * float(test.standard_error[0])
    low, high = hypothesis.declaration.bounds
    names = [name_of(evidence.columns[one]) for one in explainer.rivals(k, causes)]
    return Cause(
        name=name_of(hypothesis),
        component=component_of(hypothesis),
        kind="wrong_value" if hypothesis.listed(explainer.nominal) else "missing_effect",
        parameter=hypothesis.parameter,
        unit=hypothesis.declaration.unit,
        nominal=nominal,
        estimate=min(max(estimate, low), high),
        interval=(estimate - error, estimate + error),
        p_value=named.explanation.p_values[k],
        gap_share=share,
        **{"class": tuple(dict.fromkeys(names))},
    )


def _signs(found: Signs) -> list[Cause]:
    if not found.significant:
        return []
    return [
        Cause(
            name=SIGNS,
            component=None,
            kind="missing_effect",
            parameter="share",
            unit="1",
            nominal=0.0,
            estimate=found.share,
            interval=found.interval,
            p_value=0.0,
            gap_share=found.share,
            **{"class": (SIGNS,)},
        )
    ]


def _where(causes: Sequence[Cause], left: Leftover | None, unexplained: float) -> Where:
    shares = {phase: unexplained * left.shares[phase] if left else 0.0 for phase in PHASES}
    for cause in causes:
        effect = cause.name if cause.name in catalogue() else "table_bounce"
        shares[PHASE_OF[catalogue()[effect].acts]] += cause.gap_share
    total = max(sum(shares.values()), 1e-12)
    return Where(**{phase: share / total for phase, share in shares.items()})


def _shapley(explainer: Explainer, causes: Places) -> dict[int, float]:
    """Return each cause's part of the gain: the mean of what it adds to all orders of others."""
    count = len(causes)
    gains = {
        frozenset(some): max(explainer.gain(tuple(some)), 0.0)
        for size in range(count + 1)
        for some in itertools.combinations(causes, size)
    }
    parts = dict.fromkeys(causes, 0.0)
    for some, gain in gains.items():
        for k in set(causes) - some:
            orders = factorial(len(some)) * factorial(count - len(some) - 1) / factorial(count)
            parts[k] += orders * (gains[some | {k}] - gain)
    return parts
