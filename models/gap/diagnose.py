"""Diagnose: from shots and a simulator to a verdict."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from models.ball.simulator import Simulator
from models.gap.fit.refit import fit_nuisance
from models.gap.fit.shot_fit import refit_shots
from models.gap.fit.shots import Shots
from models.gap.inference.score_test import Evidence
from models.gap.locate.attribution import locate
from models.gap.location import Located
from models.gap.name.gap_share import shares
from models.gap.name.intervals import within
from models.gap.name.label_signs import LabelSigns, find_flipped_labels, no_flipped_labels
from models.gap.name.naming import SIGNS, Named, Question, name
from models.gap.name.selection import evidence_about
from models.gap.name.unexplained import UnexplainedStructure, find_unexplained
from models.gap.settings import GapSettings
from models.gap.types import PHASES, Places
from models.gap.verdict import (
    Answer,
    Cause,
    Gap,
    Unexplained,
    Verdict,
    Where,
    component_of,
    label_of,
    name_of,
)
from models.gap.verify.limitations import WANDERING, limits, misled
from models.gap.verify.prediction_error import errors, gap

LEVEL = GapSettings().level
HELD_OUT = 3  # one shot in so many
# Of the work, done when the causes are named, the shots kept from naming fitted, and the rest seen.
NAMED, FITTED, LOOKED = 0.6, 0.75, 0.9


Sight = tuple[dict[str, float], tuple[str, ...]]  # sizes that shots show, and what they do not


def diagnose(
    shots: Shots,
    simulator: Simulator,
    level: float = LEVEL,
    withheld: Sequence[str] = (),
    progress: Callable[[float], None] = lambda share: None,
    sight: Callable[[Sight], None] = lambda sight: None,
) -> Verdict:
    """Say where shots and a simulator disagree, and why.

    Two shots in three serve for naming, by recordings where there are several; the rest judge the
    names and show how far the gap closes.

    Args:
        shots: measured.
        simulator: to compare with.
        level: chance of a false name in a set without any gap.
        withheld: effects of the catalogue that are not in question.
        progress: is told the share of the work that is done, whenever a part of it is.
        sight: is told what the shots can show before causes are looked for.

    Raises:
        ValueError: there are fewer than three shots.
    """
    if len(shots) < HELD_OUT:
        raise ValueError(f"{len(shots)} shots are too few; give at least {HELD_OUT}")
    settings = GapSettings(level=level)
    question = Question(simulator, settings, tuple(withheld))
    held = held_out(shots)
    labels = no_flipped_labels(shots[~held], settings)
    named = name(shots[~held], question, lambda first: sight(_sight(first, labels, question)))
    progress(NAMED)
    noise, fresh = named.fit.noise_estimate.noise, shots[held]
    about = fit_nuisance(fresh, named.fit.simulator, noise, settings.fit)
    if named.signs.significant:
        fresh = find_flipped_labels(fresh, about, settings).corrected(fresh)
        about = fit_nuisance(fresh, named.fit.simulator, noise, settings.fit)
    progress(FITTED)
    left = find_unexplained(named.fit, settings, question.withheld)
    found = left.p_value <= level and left.confirmed(about)
    verdict = _verdict(named, left if found else None, left.p_value, shots, question)
    progress(LOOKED)
    if (fresh.valid.sum(axis=1) > settings.observed_samples).any():
        after = errors(about, simulator, named.simulator, noise, named.spins, settings)
        verdict = judged(verdict, gap(after, settings))
    progress(1.0)
    return verdict


def held_out(shots: Shots) -> np.ndarray:
    """Return (B,) which shots are kept from naming: whole recordings where there are several."""
    groups, member = np.unique(shots.groups.astype(str), return_inverse=True)
    units = member if len(groups) >= 2 * HELD_OUT else np.arange(len(shots))
    order = np.random.default_rng(0).permutation(units.max() + 1)
    return np.asarray(order[units] % HELD_OUT == 0)


def detectable(evidence: Evidence) -> Sight:
    """Return the smallest size of every number that shots would show, and what they are blind to.

    Args:
        evidence: of the shots, before causes are looked for.
    """
    told = evidence.decidable(evidence.free)
    sizes = {
        label_of(evidence.columns[k]): evidence.minimum_detectable_effect(k, evidence.free)
        for k in told
    }
    return sizes, tuple(label_of(one) for one in evidence.columns if label_of(one) not in sizes)


def _sight(first: Evidence, labels: LabelSigns, question: Question) -> Sight:
    sizes, blind = detectable(first)
    if labels.labelled and SIGNS not in question.withheld:
        sizes[SIGNS] = labels.detectable
        blind = tuple(one for one in blind if one != SIGNS)
    return sizes, blind


def _first(named: Named, question: Question) -> Evidence:
    """Return the evidence before causes were looked for."""
    return evidence_about(named.before, question.simulator, question.settings, question.withheld)


def _verdict(
    named: Named,
    left: UnexplainedStructure | None,
    p_value: float,
    shots: Shots,
    question: Question,
) -> Verdict:
    gains = shares(named.explainer.set_scores, named.explanation.causes)
    turned = _gain_of_signs(named)
    whole = max(sum(gains.values()) + turned, 1e-12)
    whole += left.gain if left else 0.0
    causes = [*_causes(named, gains, whole), *_signs(named.signs, turned / whole)]
    causes.sort(key=lambda one: -one.gap_share)
    sizes, blind = _sight(_first(named, question), named.signs, question)
    unexplained = Unexplained(
        share=left.gain / whole if left else 0.0,
        p_value=p_value,
        where=left.where if left else None,
        lead=left.candidate_formula if left else None,
    )
    located = locate(named.fit, question.simulator, question.settings, question.withheld)
    return Verdict(
        verdict=_answer(causes, left is not None, named.settled),
        effects=tuple(causes),
        unexplained=unexplained,
        where=_where(located, turned / whole),
        gap=None,
        detectable=sizes,
        blind_to=blind,
        limits=(*limits(shots, causes, blind), *(() if named.settled else (WANDERING,))),
        located=located,
    )


def judged(verdict: Verdict, found: Gap | None) -> Verdict:
    """Return the verdict after shots that naming never saw: causes that mislead are no names."""
    verdict = verdict.model_copy(update={"gap": found})
    if not (found and found.worse and verdict.effects):
        return verdict
    said = (*verdict.limits, misled(found))
    return verdict.model_copy(update={"verdict": "unknown", "limits": said})


def _answer(causes: Sequence[Cause], unknown: bool, settled: bool) -> Answer:
    if unknown:
        return "unknown"
    if not causes:
        return "no_gap"
    single = settled and all(len(one.possible) == 1 for one in causes)
    return "named" if single else "ambiguous"


def _causes(named: Named, gains: dict[int, float], whole: float) -> list[Cause]:
    places = named.explanation.causes
    return [_cause(named, k, places, gains[k] / whole) for k in places]


def _cause(named: Named, k: int, causes: Places, share: float) -> Cause:
    explainer = named.explainer
    evidence, hypothesis = explainer.evidence, explainer.evidence.columns[k]
    test = evidence.score_test([k], [one for one in causes if one != k])
    nominal = hypothesis.value(explainer.nominal)
    found = nominal + float(test.estimate[0])
    estimate, interval = within(
        found, float(test.margin[0]), hypothesis.declaration.bounds, evidence.settings
    )
    names = [name_of(evidence.columns[one]) for one in explainer.alternatives(k, causes)]
    return Cause(
        name=name_of(hypothesis),
        component=component_of(hypothesis),
        kind="wrong_value" if hypothesis.listed(explainer.nominal) else "missing_effect",
        parameter=hypothesis.parameter,
        unit=hypothesis.declaration.unit,
        nominal=nominal,
        estimate=estimate,
        interval=interval,
        p_value=named.explanation.p_values[k],
        gap_share=share,
        **{"class": tuple(dict.fromkeys(names))},
    )


def _gain_of_signs(named: Named) -> float:
    """Return by how much twice the log likelihood grows when labels are read with right signs."""
    if not named.signs.significant:
        return 0.0
    settings, found = named.signs.settings.fit, named.fit
    rows = np.array(sorted(named.signs.flipped))
    corrected, nuisance = found.linear.shots[rows], found.linear.nuisance[rows]
    as_read = replace(corrected, labels=-corrected.labels)
    costs = [
        refit_shots(
            shots, found.simulator, nuisance, found.noise_estimate.noise, settings
        ).cost.sum()
        for shots in (as_read, corrected)
    ]
    return max(float(costs[0] - costs[1]), 0.0)


def _signs(found: LabelSigns, share: float) -> list[Cause]:
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
            gap_share=share,
            **{"class": (SIGNS,)},
        )
    ]


def _where(located: Located | None, turned: float) -> Where:
    """Return where the gap arises; the share of labels that read backwards is the sensor's."""
    shares = located.where if located else dict.fromkeys(PHASES, 0.0)
    parts = {phase: (1 - turned) * share for phase, share in shares.items()}
    parts["sensor"] += turned
    total = max(sum(parts.values()), 1e-12)
    return Where(**{phase: part / total for phase, part in parts.items()})
