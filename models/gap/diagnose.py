"""From shots and a simulator to a verdict: name, locate, amend, verify (docs/naming.md)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from models.ball.simulator import Simulator
from models.gap.fit.refit import RefitResult, fit_nuisance
from models.gap.fit.shots import Shots, held_out
from models.gap.locate.attribution import locate
from models.gap.name.causes import (
    camera_cause,
    camera_nodes,
    cause,
    default_role,
    detection_limits,
    label_signs_cause,
)
from models.gap.name.distortion import CAMERA
from models.gap.name.label_readings import all_as_read, read_labels, without_labels
from models.gap.name.naming import Named, name, without_cause
from models.gap.name.parts import UNEXPLAINED, parts
from models.gap.name.selection import evidence_about
from models.gap.name.unexplained import UnexplainedStructure, find_unexplained
from models.gap.name.variation import variations
from models.gap.settings import DEFAULTS, GapSettings, Question
from models.gap.types import PHASES
from models.gap.verdict import (
    Answer,
    Cause,
    Check,
    DetectionLimits,
    Gap,
    PhaseShares,
    Unexplained,
    Verdict,
    Worth,
)
from models.gap.verify.checks import checks
from models.gap.verify.limitations import limitations, of_labels
from models.gap.verify.prediction_error import Errors, HeldOut, gap
from models.gap.verify.roles import Judgement
from models.gap.verify.worth import Worths

# Share of the work that is done when causes are named, the gap is located, and roles are found.
NAMED, LOCATED = 0.65, 0.8


def diagnose(
    shots: Shots,
    simulator: Simulator,
    settings: GapSettings = DEFAULTS,
    withheld: Sequence[str] = (),
    progress: Callable[[float], None] = lambda share: None,
    on_limits: Callable[[DetectionLimits], None] = lambda limits: None,
) -> Verdict:
    """Return where shots and a simulator disagree, and why.

    Two shots in three serve for naming, by recordings where there are several; the others are held
    out for verification.

    Args:
        shots: measured.
        simulator: the nominal one, to compare with.
        settings: thresholds, such as the level: the probability of a false cause without any gap.
        withheld: effects of the catalogue that are not in question.
        progress: called with the share of the work that is done.
        on_limits: called with what the shots can show, before causes are searched for.

    Raises:
        ValueError: there are fewer than three shots.
    """
    least = settings.verify.held_out
    if len(shots) < least:
        raise ValueError(f"{len(shots)} shots are too few; give at least {least}")
    question, held = Question(simulator, settings, tuple(withheld)), held_out(shots, settings)
    labels = all_as_read(shots[~held], settings)
    named = name(
        shots[~held],
        question,
        lambda evidence: on_limits(detection_limits(evidence, labels, question)),
    )
    progress(NAMED)
    whole = _Verified.of(named, shots[held], question)
    structure = find_unexplained(named.fit, question)
    significant = structure.p_value <= settings.level and structure.confirmed(whole.verification)
    located = locate(named.fit, question, parts(named, structure if significant else None))
    shares = located.gap_shares if located else {}
    progress(LOCATED)
    structure_share = shares.get(UNEXPLAINED, 1.0) if significant else 0.0
    fits = whole.fits and structure_share <= settings.verify.max_unexplained
    main, worths, minor = _reduced(whole, fits, shares)
    limits = detection_limits(evidence_about(named.before, question), named.readings, question)
    varying = variations(main.named)
    found = (*_main_causes(main.named, worths, shares), *minor)
    verdict = Verdict(
        verdict=_answer(found, main, structure_share, bool(varying)),
        causes=found,
        variations=varying,
        unexplained=_unexplained(structure, significant, shares),
        phases=PhaseShares(**(located.phase_shares if located else dict.fromkeys(PHASES, 0.0))),
        gap=main.gap,
        checks=main.checks,
        camera=camera_nodes(main.named),
        minimum_detectable=limits.minimum_detectable,
        not_identifiable=limits.not_identifiable,
        limitations=(
            *of_labels(named.readings),
            *limitations(shots, found, limits, named.settled, settings),
        ),
        located=located,
    )
    progress(1.0)
    return verdict


@dataclass(frozen=True)
class _Verified:
    """Causes, and what held-out shots say of them."""

    named: Named
    measured: Shots
    question: Question
    verification: RefitResult
    held: HeldOut | None
    errors: Errors | None

    @classmethod
    def of(cls, named: Named, shots: Shots, question: Question) -> "_Verified":
        """Return the causes verified on held-out shots, as they were measured."""
        settings, noise = question.settings, named.fit.noise_estimate.noise
        verification = _fit_held_out(shots, named, settings)
        held = HeldOut.of(verification, shots, noise, settings)
        if not len(held.shots):
            return cls(named, shots, question, verification, None, None)
        seen = held.corrected if named.distortion else held.shots
        errors = held.errors((question.simulator, named.simulator), named.spins, seen)
        return cls(named, shots, question, verification, held, errors)

    @cached_property
    def gap(self) -> Gap | None:
        """Prediction errors; None where held-out shots are too short."""
        return gap(self.errors, self.question.settings) if self.errors else None

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether the model fits held-out shots."""
        return checks(self.verification, self.errors, self.question.settings)

    @property
    def fits(self) -> bool:
        """Whether all checks pass."""
        return all(check.passed for check in self.checks)

    def without(self, k: int) -> "_Verified":
        """Return the causes but one, refitted."""
        named = without_cause(self.named, k, self.question)
        return _Verified.of(named, self.measured, self.question)

    def judgement(self, fits: bool) -> Judgement:
        """Return what decides about the roles of the causes."""
        worths = Worths.of(self.named, self.verification, self.held, self.question)
        before = float(np.mean(self.gap.before_mm)) if self.gap else 0.0
        return Judgement(self.named, worths, fits, before)


def _reduced(
    whole: _Verified, fits: bool, shares: dict[str, float]
) -> tuple[_Verified, dict[str, Worth], list[Cause]]:
    """Return the main causes with what they are worth, and the minor ones.

    ``fits`` says whether the model with all of them fits the shots.
    """
    question, minor = whole.question, []
    judgement = whole.judgement(fits)
    while (k := judgement.weakest(question)) is not None:
        worth = judgement.worths.of_causes.get(judgement.identity(k))
        minor.append(cause(whole.named, k, "minor", shares, worth))
        whole = whole.without(k)
        judgement = whole.judgement(fits)
    minor.sort(key=lambda one: -one.gap_share)
    return whole, judgement.worths.of_causes, minor


def _main_causes(named: Named, worths: dict[str, Worth], shares: dict[str, float]) -> list[Cause]:
    """Return leading causes and sensor faults, each the largest share first."""
    columns = named.explainer.evidence.columns
    found = [
        cause(named, k, default_role(columns[k]), shares, worths.get(columns[k].identity))
        for k in named.explanation.causes
    ]
    if named.distortion is not None:
        found.append(camera_cause(named, named.distortion, shares, worths.get(CAMERA.identity)))
    if named.readings.significant:
        found.append(label_signs_cause(named, shares))
    return sorted(found, key=lambda one: (one.role != "leading", -one.gap_share))


def _answer(
    found: Sequence[Cause], main: _Verified, unexplained_share: float, varying: bool
) -> Answer:
    """Return the verdict in one word; the share is that of significant structure."""
    if unexplained_share > main.question.settings.verify.max_unexplained:
        return "unknown"
    causes = [one for one in found if one.role != "minor"]
    if not causes:
        return "unknown" if varying or unexplained_share > 0.0 or not main.fits else "no_gap"
    certain = main.named.settled and not any(one.ambiguous for one in causes)
    return "named" if certain else "ambiguous"


def _unexplained(
    structure: UnexplainedStructure, significant: bool, shares: dict[str, float]
) -> Unexplained:
    """Return the part of a verdict about structure that no cause explains."""
    return Unexplained(
        share=shares.get(UNEXPLAINED, 0.0),
        p_value=structure.p_value,
        phase=structure.phase if significant else None,
        formula=structure.candidate_formula if significant else None,
    )


def _fit_held_out(shots: Shots, named: Named, settings: GapSettings) -> RefitResult:
    """Return held-out shots fitted about the amended simulator, with corrected measurements."""
    simulator, noise = named.fit.simulator, named.fit.noise_estimate.noise
    if named.readings.useless:
        shots = without_labels(shots)
    if named.distortion is not None:
        errors, field = named.fit.camera_errors, named.distortion.field
        shots = field.on(shots, shots.positions).corrected(errors).without_shared()
    about = fit_nuisance(shots, simulator, noise, settings.fit)
    if not named.readings.doubtful:
        return about
    readings = read_labels(shots, about, settings)
    # Two flipped labels are no cause, but where there is one, each of them is corrected.
    usable = readings.negated if named.readings.significant else readings.left_out
    return fit_nuisance(usable(shots), simulator, noise, settings.fit)
