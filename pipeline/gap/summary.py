"""A verdict as text: its sentences for the terminal and the top of the page, and their parts."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Cause, Check, DetectionLimits, Gap, Role, Variation, Verdict
from rallygap.models.gap.verify.limitations import experiment
from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.gap.measured_shots import LabelCounts, MeasuredShots
from rallygap.pipeline.web.labels import PLACES
from rallygap.pipeline.web.numbers import (
    SIGNIFICANT,
    interval_text,
    number,
    p_text,
    percent,
    with_unit,
)

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.amended_scene import AmendedScene

ROLES: dict[Role, str] = {
    "leading": "leading cause",
    "sensor": "sensor fault",
    "minor": "minor structure",
}
TYPICAL_MS = 200  # the horizon of the summary, where shots are that long
MOST_LISTED = 3  # names in a sentence; tables list all

# What a failed check says, by its ratio and the largest allowed one, plain and in percent; and
# what is doubtful then.
MISFITS = {
    "residuals": (
        "residuals of held-out shots are {0:.3g} times as large as it expects",
        "intervals and p-values",
    ),
    "prediction": (
        "predictions err {0:.3g} times as much as it expects",
        "intervals and small causes",
    ),
    "landing": (
        "predicted landings err {0:.3g} times as much as it expects",
        "causes at the table",
    ),
    "labels": (
        "spin labels err by {2:.0f} % of the spin (allowed {3:g} %)",
        "causes that rest on spin labels",
    ),
    "bounces": (
        "the restitution differs by {0:.2g} from bounce to bounce (allowed {1:g})",
        "causes at the table",
    ),
}

# What to do next.
CHECK_LABELS = "check signs, axes and units of the spin labels, and diagnose again."
CHECK_BOUNCES = (
    "let one ball bounce at one place, then at others, then other balls; diagnose those that "
    "bounce alike by themselves."
)
CHECK_RECORDINGS = (
    "look for errors of the recordings, such as outliers, wrong time stamps or an old "
    "calibration, and diagnose again."
)
KEEP_NOMINAL = (
    "keep the nominal simulator. Record more shots at other speeds and spins, and diagnose again."
)
CONFIRM = "predict with amended.yaml, and diagnose new recordings with it to confirm the causes."
SPLIT = (
    "look for what changes between shots, such as balls, air or cameras, and diagnose the parts of "
    "the session by themselves. No constant value closes this gap."
)
UNSETTLED = (
    "record more shots at other speeds and spins, and measure spins; until then, amended.yaml is "
    "one of several possible simulators."
)


@dataclass(frozen=True)
class Findings:
    """A verdict and what made it.

    Attributes:
        measured: the data.
        simulator: the nominal one.
        simulator_name: the user's name for it.
        settings: of the workflow.
        verdict: on these.
        balls: that are to be expected after these shots.
        minor: whether minor structure is amended as well.
        handed: what is given back where the simulator is a scene of MuJoCo.
    """

    measured: MeasuredShots
    simulator: Simulator
    simulator_name: str
    settings: GapSettings
    verdict: Verdict
    balls: Expected
    minor: bool = False
    handed: "AmendedScene | None" = None

    @property
    def outcome(self) -> list[str]:
        """The verdict in sentences: reservations, answer, errors, causes, and what to do next."""
        return list(self._outcome())

    @property
    def details(self) -> list[str]:
        """Where the gap arises, what the shots can show, and how an amended scene flies."""
        return list(self._details())

    def _outcome(self) -> Iterator[str]:
        verdict, net, unexplained = self.verdict, self.verdict.net, self.verdict.unexplained
        yield from reservations(verdict)
        yield self._answer()
        if verdict.gap:
            yield from self._errors(verdict.gap)
        if net:
            what = f"Prediction error up to {net.horizon_ms} ms after the net"
            sizes = f"{net.before_mm:.1f} mm before, {net.after_mm:.1f} mm after amending"
            yield f"{what}: {sizes} ({counted(net.held_out, 'held-out contact')})."
        yield from map(cause_sentence, verdict.main_causes)
        minor = minor_causes(verdict)
        if minor:
            names = listed([cause.identity for cause in minor])
            share = percent(sum(cause.gap_share for cause in minor))
            yield f"Minor structure, not amended: {names}; {share} of the gap."
        yield from map(variation_sentence, verdict.variations)
        if unexplained.phase:
            place = PLACES[unexplained.phase]
            yield f"Unexplained structure {place}: {percent(unexplained.share)} of the gap."
            yield f"Candidate formula for it, not a cause: {unexplained.formula}."
        yield f"Next: {self._next_step()}"

    def _details(self) -> Iterator[str]:
        shares, located = self.verdict.phases.model_dump(), self.verdict.located
        if any(shares.values()):
            parts = [f"{percent(shares[phase])} {place}" for phase, place in PLACES.items()]
            yield f"The gap arises {', '.join(parts[:2])} and {parts[2]}."
        if located and located.growth and located.growth[0].p_value <= SIGNIFICANT:
            first = located.growth[0]
            yield (
                f"The trajectory discrepancy depends most on {first.covariate}, which explains "
                f"{percent(first.share)} of its variance ({p_text(first.p_value)})."
            )
        shown, hidden = len(self.verdict.minimum_detectable), self.verdict.not_identifiable
        text = f"Identifiable from these shots: {shown} of {shown + len(hidden)} parameters"
        yield f"{text}; not {', '.join(hidden)}." if hidden else f"{text}."
        if self.handed:
            yield from self.handed.sentences

    def _answer(self) -> str:
        shots = f"{len(self.measured.shots)} shots of {self.measured.name}"
        differ = f"{shots} differ from the simulator {self.simulator_name}"
        roles = Counter(cause.role for cause in self.verdict.main_causes)
        causes = " and ".join(counted(count, ROLES[role]) for role, count in roles.items())
        return {
            "no_gap": f"{answer_title(self.verdict)}: {shots} agree with the simulator "
            f"{self.simulator_name} down to the minimum detectable effects (5.8 sigma).",
            "named": f"Named: {differ}; {causes} identified.",
            "ambiguous": f"Ambiguous: {differ}; {causes} found, but not all are "
            "identified uniquely.",
            "unknown": f"Unknown: {differ}; the effects of the catalogue do not explain the "
            "difference.",
        }[self.verdict.verdict]

    def _errors(self, gap: Gap) -> Iterator[str]:
        reached = [k for k, ms in enumerate(gap.horizons_ms) if ms <= TYPICAL_MS]
        k = max(reached, default=0)
        sizes = [f"{values[k]:.1f} mm" for values in (gap.before_mm, gap.after_mm, gap.floor_mm)]
        what = f"Prediction error on held-out shots, {gap.horizons_ms[k]} ms ahead"
        yield self._compared(what, *sizes)
        if gap.landing:
            sizes = [f"{place:.1f} mm and {time:.2f} ms" for place, time in gap.landing.sizes]
            yield self._compared("Prediction error at landing", *sizes)

    def _compared(self, what: str, before: str, after: str, floor: str) -> str:
        sizes = f"{before} before, {after} after amending" if self.verdict.main_causes else before
        return f"{what}: {sizes}; prediction floor {floor}."

    def _next_step(self) -> str:
        verdict, few = self.verdict, self.settings.verify.few_shots
        if predicts_worse(verdict):
            return KEEP_NOMINAL
        if verdict.misfits:
            names = {check.name for check in verdict.misfits}
            single = names.pop() if len(names) == 1 else ""
            return {"labels": CHECK_LABELS, "bounces": CHECK_BOUNCES}.get(single, CHECK_RECORDINGS)
        if verdict.verdict == "no_gap":
            if len(self.measured.shots) < few:
                return f"nothing to amend. Record {few} shots or more to detect smaller effects."
            return "nothing to amend. More shots would detect smaller effects."
        if verdict.verdict == "unknown":
            phase = verdict.unexplained.phase
            where = f" {PLACES[phase]}" if phase else ""
            missing = (
                f"the catalogue lacks an effect{where}; add one (docs/add-an-effect.md), and "
                "diagnose again. The candidate formula is a hint."
            )
            return SPLIT if verdict.variations and not phase else missing
        return CONFIRM if verdict.verdict == "named" else self._separating_step()

    def _separating_step(self) -> str:
        cause = next((cause for cause in self.verdict.main_causes if cause.ambiguous), None)
        if cause is None:
            return UNSETTLED
        others = listed(cause.alternatives)
        separating = experiment(cause, self.measured.shots, self.settings)
        return f"predict with amended.yaml; to tell {cause.identity} from {others}, {separating}."


def answer_title(verdict: Verdict) -> str:
    """Return the answer in a few words."""
    title = verdict.verdict.replace("_", " ").capitalize()
    no_gap_but = verdict.verdict == "no_gap" and minor_causes(verdict)
    return f"{title} but for minor structure" if no_gap_but else title


def minor_causes(verdict: Verdict) -> list[Cause]:
    """Return the causes that are minor structure."""
    return [cause for cause in verdict.causes if cause.role == "minor"]


def reservations(verdict: Verdict) -> Iterator[str]:
    """Yield what speaks against relying on a verdict, one sentence or two each."""
    if verdict.misfits:
        misfits = "; ".join(_misfit(check) for check in verdict.misfits)
        doubtful = ", ".join(dict.fromkeys(MISFITS[check.name][1] for check in verdict.misfits))
        yield (
            f"The fitted model does not describe these shots: {misfits}. Do not rely on {doubtful}."
        )
    if verdict.gap and verdict.gap.reduction_mm and predicts_worse(verdict):
        low, high = verdict.gap.reduction_mm
        growth = float(np.mean(verdict.gap.after_mm) - np.mean(verdict.gap.before_mm))
        yield (
            f"The amended simulator predicts worse than the nominal one: held-out predictions err "
            f"{growth:.1f} mm more, mean over horizons (95 % {-high:.1f} to {-low:.1f}). "
            "Do not use amended.yaml."
        )


def predicts_worse(verdict: Verdict) -> bool:
    """Return whether amended predictions are significantly worse than nominal ones."""
    reduction = verdict.gap.reduction_mm if verdict.gap else None
    return reduction is not None and reduction[1] < 0.0


def _misfit(check: Check) -> str:
    least, most = check.allowed
    text = MISFITS[check.name][0].format(check.ratio, most, 100 * check.ratio, 100 * most)
    if check.name in ("labels", "bounces"):
        return text
    low, high = check.interval
    return f"{text} (95 % {low:.3g} to {high:.3g}; allowed {least:.3g} to {most:.3g})"


def usage_lines(measured: MeasuredShots) -> Iterator[str]:
    """Yield what is used and what is doubtful as lines of text."""
    yield f"Used: {episodes_text(measured)}. Spin labels: {labels_text(measured.labels)}."
    if len(measured.nets):
        yield f"Contacts with the net, with an arc before and after: {len(measured.nets):,}."
    for doubt in measured.doubts:
        yield f"Doubtful: {doubt}."


def detection_lines(measured: MeasuredShots, limits: DetectionLimits) -> Iterator[str]:
    """Yield the detection limits as lines of text, before causes are searched for."""
    sizes = limits.minimum_detectable
    width = max(map(len, sizes), default=0)
    shots = f"{len(measured.shots)} shots of {measured.name}"
    yield f"Minimum detectable effects (5.8 sigma) in {shots}:"
    for identity, size in sizes.items():
        unit = Hypothesis.from_identity(identity).declaration.unit
        yield f"  {identity:<{width}}  {with_unit(size, unit)}"
    if limits.not_identifiable:
        yield f"Not identifiable: {', '.join(limits.not_identifiable)}."


def listed(names: Sequence[str]) -> str:
    """Return the names in a row, or how many there are where a sentence cannot hold them."""
    return ", ".join(names) if len(names) <= MOST_LISTED else f"{len(names)} other parameters"


def counted(count: int, noun: str) -> str:
    """Return a number of things, such as ``2 leading causes``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def title(identity: str) -> str:
    """Return the catalogue's description of the effect of a parameter."""
    return catalogue()[Hypothesis.from_identity(identity).effect].title


def cause_sentence(cause: Cause) -> str:
    """Return a cause with its estimate, share, and what it is worth alone."""
    missing = cause.kind == "missing_effect"
    before = "missing in the simulator" if missing else f"simulator {number(cause.nominal)}"
    worth = ""
    if cause.worth:
        mm, (low, high) = cause.worth.mm, cause.worth.interval
        size = f"{mm:.1f} mm more (95 % {low:.1f} to {high:.1f})"
        if mm < 0.0:
            size = f"{-mm:.1f} mm less (95 % {-high:.1f} to {-low:.1f})"
        worth = f"; without it predictions err {size}"
    others = f" Not separable from {listed(cause.alternatives)}." if cause.alternatives else ""
    return (
        f"{ROLES[cause.role].capitalize()} {cause.identity} ({title(cause.identity)}): "
        f"estimate {with_unit(cause.estimate, cause.unit)} (95 % {interval_text(cause.interval)}), "
        f"{before}; {percent(cause.gap_share)} of the gap{worth}.{others}"
    )


def variation_sentence(variation: Variation) -> str:
    """Return a parameter that is not the same in all shots, with the size of its variation."""
    size = f"{with_unit(variation.size, variation.unit)} (95 % {interval_text(variation.interval)})"
    what = {
        "drift": f"drifts over the session, by {size} from the first shot to the last",
        "by_side": f"is larger where y > 0 than where y < 0, by {size}",
        "between_shots": f"differs from shot to shot, with a standard deviation of {size}",
    }[variation.kind]
    others = variation.possible[1:]
    tail = f" Not separable from {listed(others)}." if others else ""
    return f"{variation.identity} ({title(variation.identity)}) {what}; not amended.{tail}"


def episodes_text(measured: MeasuredShots) -> str:
    """Return how many episodes are used, and why others are not."""
    used, recordings = len(measured.shots), measured.recordings
    text = f"{used:,} of {measured.episodes:,} episodes in {recordings:,} recordings"
    return _with_reasons(text, measured.left_out)


def labels_text(labels: LabelCounts) -> str:
    """Return how many spin labels are used, and why others are not."""
    if not labels.read:
        return "none"
    reasons = {"implausible": labels.implausible, "outside these episodes": labels.elsewhere}
    return _with_reasons(f"{labels.used:,} of {labels.read:,}", reasons)


def reasons_text(counts: Mapping[str, int]) -> str:
    """Return counts with their reasons, such as ``2 broken, 1 too short``."""
    return ", ".join(f"{count:,} {reason}" for reason, count in counts.items() if count)


def _with_reasons(text: str, counts: Mapping[str, int]) -> str:
    reasons = reasons_text(counts)
    return f"{text}; left out: {reasons}" if reasons else text
