"""From shots and a simulator to a verdict: name, locate, amend, verify (docs/naming.md)."""

from collections.abc import Callable, Sequence

from models.ball.simulator import Simulator
from models.gap.fit.refit import RefitResult, fit_nuisance
from models.gap.fit.shots import Shots, held_out
from models.gap.locate.attribution import locate
from models.gap.location import Located
from models.gap.name.causes import GapShares, answer, causes, detection_limits, unexplained
from models.gap.name.label_signs import find_flipped_labels, no_flipped_labels
from models.gap.name.naming import Named, name
from models.gap.name.selection import evidence_about
from models.gap.name.unexplained import find_unexplained
from models.gap.settings import DEFAULTS, GapSettings, Question
from models.gap.types import PHASES
from models.gap.verdict import DetectionLimits, Gap, PhaseShares, Verdict
from models.gap.verify.limitations import limitations, rejected_if_worse
from models.gap.verify.prediction_error import errors, gap

# Share of the work that is done when causes are named, held-out shots fitted, and the gap located.
NAMED, FITTED, LOCATED = 0.6, 0.75, 0.9


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
    labels = no_flipped_labels(shots[~held], settings)
    named = name(
        shots[~held],
        question,
        lambda evidence: on_limits(detection_limits(evidence, labels, question)),
    )
    progress(NAMED)
    verification = _fit_held_out(shots[held], named, settings)
    progress(FITTED)
    structure = find_unexplained(named.fit, question)
    significant = structure.p_value <= settings.level and structure.confirmed(verification)
    gap_shares = GapShares.of(named, structure if significant else None)
    found, before = causes(named, gap_shares), evidence_about(named.before, question)
    limits = detection_limits(before, named.signs, question)
    located = locate(named.fit, question)
    progress(LOCATED)
    verdict = Verdict(
        verdict=answer(found, significant, named.settled),
        causes=found,
        unexplained=unexplained(structure, significant, gap_shares),
        phases=_phase_shares(located, gap_shares.label_signs),
        gap=_verify(verification, named, question),
        minimum_detectable=limits.minimum_detectable,
        not_identifiable=limits.not_identifiable,
        limitations=limitations(shots, found, limits, named.settled, settings),
        located=located,
    )
    progress(1.0)
    return rejected_if_worse(verdict)


def _fit_held_out(shots: Shots, named: Named, settings: GapSettings) -> RefitResult:
    """Return held-out shots fitted about the amended simulator, flipped labels corrected."""
    simulator, noise = named.fit.simulator, named.fit.noise_estimate.noise
    if named.field is not None:
        errors = named.fit.camera_errors
        shots = named.field.on(shots, shots.positions).corrected(errors).without_shared()
    about = fit_nuisance(shots, simulator, noise, settings.fit)
    if not named.signs.significant:
        return about
    corrected = find_flipped_labels(shots, about, settings).corrected(shots)
    return fit_nuisance(corrected, simulator, noise, settings.fit)


def _phase_shares(located: Located | None, label_signs: float) -> PhaseShares:
    """Return the gap's shares by phase, flipped labels as the sensor's; zero without a gap."""
    shares = located.phase_shares if located else dict.fromkeys(PHASES, 0.0)
    parts = {phase: (1 - label_signs) * share for phase, share in shares.items()}
    parts["sensor"] += label_signs
    total = max(sum(parts.values()), 1e-12)
    return PhaseShares(**{phase: part / total for phase, part in parts.items()})


def _verify(verification: RefitResult, named: Named, question: Question) -> Gap | None:
    """Return prediction errors of both simulators; None where held-out shots are too short."""
    settings, noise = question.settings, named.fit.noise_estimate.noise
    if not (verification.linear.shots.valid.sum(axis=1) > settings.observed_samples).any():
        return None
    simulators = question.simulator, named.simulator
    return gap(errors(verification, simulators, noise, named.spins, settings), settings)
