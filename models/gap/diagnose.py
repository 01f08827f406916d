"""From shots and a simulator to a verdict: name, locate, amend, verify (docs/naming.md)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.shots import Shots, held_out
from rallygap.models.gap.locate.attribution import locate
from rallygap.models.gap.location import Located
from rallygap.models.gap.name.causes import (
    camera_cause,
    camera_nodes,
    cause,
    default_role,
    detection_limits,
    label_signs_cause,
)
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.name.label_readings import all_as_read
from rallygap.models.gap.name.naming import Named, name
from rallygap.models.gap.name.parts import UNEXPLAINED, parts
from rallygap.models.gap.name.selection import evidence_about
from rallygap.models.gap.name.unexplained import UnexplainedStructure, find_unexplained
from rallygap.models.gap.name.variation import variations
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.net.naming import name_net
from rallygap.models.gap.settings import DEFAULTS, GapSettings, Question
from rallygap.models.gap.types import PHASES
from rallygap.models.gap.verdict import (
    Answer,
    Cause,
    DetectionLimits,
    PhaseShares,
    Role,
    Unexplained,
    Verdict,
    Worth,
)
from rallygap.models.gap.verify.limitations import limitations, of_labels
from rallygap.models.gap.verify.verified import Verified

ROLES: tuple[Role, ...] = get_args(Role)  # in the order of a verdict
# Share of the work that is done when causes are named, the gap is located, and roles are found.
NAMED, LOCATED = 0.65, 0.8


def diagnose(
    shots: Shots,
    simulator: Simulator,
    settings: GapSettings = DEFAULTS,
    withheld: Sequence[str] = (),
    nets: NetContacts | None = None,
    progress: Callable[[float], None] = lambda share: None,
    on_limits: Callable[[DetectionLimits], None] = lambda limits: None,
) -> Verdict:
    """Return where shots and a simulator disagree, and why.

    Two shots in three serve for naming, the others are held out for verification: whole recordings
    if there are at least twice ``settings.verify.held_out`` of them, else single shots.

    Args:
        shots: measured.
        simulator: the nominal one, to compare with.
        settings: thresholds, such as the level: the probability of a false cause without any gap.
        withheld: effects of the catalogue that are not in question.
        nets: contacts with the net, if there are any.
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
    whole = Verified.of(named, shots[held], question)
    structure = find_unexplained(named.fit, question)
    significant = structure.p_value <= settings.level and structure.confirmed(whole.verification)
    located = locate(named.fit, question, parts(named, structure if significant else None))
    progress(LOCATED)
    verdict = _Findings(whole, structure, significant, located).verdict(shots, nets)
    progress(1.0)
    return verdict


@dataclass(frozen=True)
class _Findings:
    """What a verdict is made of.

    Attributes:
        whole: all causes.
        structure: that no effect of the catalogue explains.
        significant: whether there is such structure.
        located: where the gap arises; None without any gap.
    """

    whole: Verified
    structure: UnexplainedStructure
    significant: bool
    located: Located | None

    def verdict(self, shots: Shots, nets: NetContacts | None) -> Verdict:
        """Return the verdict on the shots, held-out ones included, and on contacts with the net."""
        named, question = self.whole.named, self.whole.question
        main, worths, minor = _reduced(self.whole, self.fits, self.shares)
        limits = detection_limits(evidence_about(named.before, question), named.readings, question)
        varying = variations(main.named)
        net = name_net(nets, main.named, question) if nets else None
        leading = _main_causes(main.named, named, worths, self.shares)
        found = _by_role([*leading, *minor, *(net.causes if net else ())])
        phases = self.located.phase_shares if self.located else dict.fromkeys(PHASES, 0.0)
        return Verdict(
            verdict=_answer(found, main, self.structure_share, bool(varying)),
            causes=found,
            variations=varying,
            unexplained=self.unexplained,
            phases=PhaseShares(**phases),
            gap=main.gap,
            net=net.errors if net else None,
            checks=main.checks,
            camera=camera_nodes(main.named),
            minimum_detectable=limits.minimum_detectable,
            not_identifiable=limits.not_identifiable,
            limitations=(
                *of_labels(named.readings),
                *limitations(shots, found, limits, named.settled, question.settings),
            ),
            located=self.located,
        )

    @property
    def shares(self) -> dict[str, float]:
        """Of causes and structure in the gap, by identity."""
        return self.located.gap_shares if self.located else {}

    @property
    def structure_share(self) -> float:
        """Of significant structure in the gap."""
        return self.shares.get(UNEXPLAINED, 1.0) if self.significant else 0.0

    @property
    def fits(self) -> bool:
        """Whether the model with all causes fits the shots' paths."""
        most = self.whole.question.settings.verify.max_unexplained
        return self.whole.paths_fit and self.structure_share <= most

    @property
    def unexplained(self) -> Unexplained:
        """The part of the verdict about structure that no cause explains."""
        return Unexplained(
            share=self.shares.get(UNEXPLAINED, 0.0),
            p_value=self.structure.p_value,
            phase=self.structure.phase if self.significant else None,
            formula=self.structure.candidate_formula if self.significant else None,
        )


# Main causes, what they are worth, and minor ones.
_Reduced = tuple[Verified, dict[str, Worth], list[Cause]]


def _reduced(whole: Verified, fits: bool, shares: dict[str, float]) -> _Reduced:
    """Return the main causes with what they are worth, and the minor ones.

    Where an error of the cameras would take the place of those that are taken out, beyond its
    interval, those that it would grow by stay. ``fits`` says whether the model with all causes fits
    the shots.
    """
    found = _without_minor(whole, fits, shares, np.inf)
    size, most = found[0].camera_size[0], whole.camera_size[1]
    return found if size <= most else _without_minor(whole, fits, shares, most)


def _without_minor(whole: Verified, fits: bool, shares: dict[str, float], most: float) -> _Reduced:
    """Take minor causes out; ``most`` is the largest error of the cameras, m, that they leave."""
    question, minor = whole.question, []
    judgement = whole.judgement(fits)
    while (k := judgement.weakest(question)) is not None:
        reduced = whole.without(k)
        if fits and k not in judgement.needed and whole.is_likelier_than(reduced):
            judgement = replace(judgement, needed=judgement.needed | {k})
            continue
        if reduced.camera_size[0] > most and k not in judgement.irreplaceable:
            judgement = replace(judgement, irreplaceable=judgement.irreplaceable | {k})
            continue
        worth = judgement.worths.of_causes.get(judgement.identity(k))
        minor.append(cause(whole.named, k, "minor", shares, worth))
        whole, judgement = reduced, reduced.judgement(fits, judgement.irreplaceable)
    return whole, judgement.worths.of_causes, minor


def _main_causes(
    named: Named, whole: Named, worths: dict[str, Worth], shares: dict[str, float]
) -> list[Cause]:
    """Return leading causes and sensor faults; ``whole`` has the minor ones too."""
    columns = named.explainer.evidence.columns
    found = [
        cause(named, k, default_role(columns[k]), shares, worths.get(columns[k].identity), whole)
        for k in named.explanation.causes
    ]
    if named.distortion is not None:
        found.append(camera_cause(named, named.distortion, shares, worths.get(CAMERA.identity)))
    if named.readings.significant:
        found.append(label_signs_cause(named, shares))
    return found


def _by_role(found: Sequence[Cause]) -> tuple[Cause, ...]:
    """Return leading causes, sensor faults and minor structure, each the largest share first."""
    return tuple(sorted(found, key=lambda one: (ROLES.index(one.role), -one.gap_share)))


def _answer(
    found: Sequence[Cause], main: Verified, unexplained_share: float, varying: bool
) -> Answer:
    """Return the verdict in one word; the share is that of significant structure."""
    if unexplained_share > main.question.settings.verify.max_unexplained:
        return "unknown"
    causes = [one for one in found if one.role != "minor"]
    if not causes:
        return "unknown" if varying or unexplained_share > 0.0 or not main.fits else "no_gap"
    certain = main.named.settled and not any(one.ambiguous for one in causes)
    return "named" if certain else "ambiguous"
