"""From shots and a simulator to a verdict: name, locate, amend, verify.

The shots are first fitted about the simulator (``fit``). ``name`` selects the causes of the gap and
refits the shots with them. ``locate`` says in which phase the gap arises; it uses the refitted
shots, which are the best description of the measurement. The refitted simulator is the amended
one, and ``verify`` compares its predictions of held-out shots with the nominal simulator's.
"""

from collections.abc import Callable, Sequence

from models.ball.simulator import Simulator
from models.gap.fit.refit import RefitResult, fit_nuisance
from models.gap.fit.shots import Shots
from models.gap.fit.split import HELD_OUT, held_out
from models.gap.locate.attribution import locate
from models.gap.locate.phase_shares import phase_shares
from models.gap.name.causes import GapShares, answer, causes, unexplained
from models.gap.name.detectable import detection_limits, limits_of
from models.gap.name.label_signs import find_flipped_labels, no_flipped_labels
from models.gap.name.naming import Named, Question, name
from models.gap.name.unexplained import find_unexplained
from models.gap.settings import GapSettings
from models.gap.verdict import DetectionLimits, Gap, Verdict
from models.gap.verify.limitations import limitations, rejected_if_worse
from models.gap.verify.prediction_error import errors, gap

LEVEL = GapSettings().level
# Share of the work that is done when causes are named, held-out shots fitted, and the gap located.
NAMED, FITTED, LOCATED = 0.6, 0.75, 0.9


def diagnose(
    shots: Shots,
    simulator: Simulator,
    level: float = LEVEL,
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
        level: probability of a false cause in a data set without any gap.
        withheld: effects of the catalogue that are not in question.
        progress: called with the share of the work that is done.
        on_limits: called with what the shots can show, before causes are searched for.

    Raises:
        ValueError: there are fewer than three shots.
    """
    if len(shots) < HELD_OUT:
        raise ValueError(f"{len(shots)} shots are too few; give at least {HELD_OUT}")
    settings, held = GapSettings(level=level), held_out(shots)
    question = Question(simulator, settings, tuple(withheld))
    labels = no_flipped_labels(shots[~held], settings)
    named = name(
        shots[~held], question, lambda first: on_limits(detection_limits(first, labels, question))
    )
    progress(NAMED)
    fresh = _fit_held_out(shots[held], named, settings)
    progress(FITTED)
    structure = find_unexplained(named.fit, settings, question.withheld)
    significant = structure.p_value <= level and structure.confirmed(fresh)
    gap_shares = GapShares.of(named, structure if significant else None)
    found, limits = causes(named, gap_shares), limits_of(named, question)
    located = locate(named.fit, simulator, settings, question.withheld)
    progress(LOCATED)
    verdict = Verdict(
        verdict=answer(found, significant, named.settled),
        causes=found,
        unexplained=unexplained(structure, significant, gap_shares),
        phases=phase_shares(located, gap_shares.label_signs),
        gap=_verify(fresh, named, question),
        minimum_detectable=limits.minimum_detectable,
        not_identifiable=limits.not_identifiable,
        limitations=limitations(shots, found, limits, named.settled),
        located=located,
    )
    progress(1.0)
    return rejected_if_worse(verdict)


def _fit_held_out(shots: Shots, named: Named, settings: GapSettings) -> RefitResult:
    """Return held-out shots fitted about the amended simulator, flipped labels corrected."""
    simulator, noise = named.fit.simulator, named.fit.noise_estimate.noise
    about = fit_nuisance(shots, simulator, noise, settings.fit)
    if not named.signs.significant:
        return about
    corrected = find_flipped_labels(shots, about, settings).corrected(shots)
    return fit_nuisance(corrected, simulator, noise, settings.fit)


def _verify(fresh: RefitResult, named: Named, question: Question) -> Gap | None:
    """Return prediction errors of both simulators; None where held-out shots are too short."""
    settings, noise = question.settings, named.fit.noise_estimate.noise
    if not (fresh.linear.shots.valid.sum(axis=1) > settings.observed_samples).any():
        return None
    found = errors(fresh, question.simulator, named.simulator, noise, named.spins, settings)
    return gap(found, settings)
