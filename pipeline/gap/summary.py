"""A verdict in sentences, for the terminal and the top of the page."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Cause, Check, DetectionLimits, Gap, Verdict
from rallygap.models.gap.verify.limitations import experiment
from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.gap.measured_shots import MeasuredShots
from rallygap.pipeline.gap.wording import (
    PLACES,
    ROLES,
    cause_sentence,
    counted,
    episodes_text,
    labels_text,
    listed,
    p_text,
    percent,
    variation_sentence,
)
from rallygap.pipeline.web.numbers import with_unit

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.amended_scene import AmendedScene

TYPICAL_MS = 200  # the horizon of the summary, where shots are that long
SIGNIFICANT = 0.05  # p-value up to which a covariate is reported

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
        verdict = self.verdict
        return [
            *reservations(verdict),
            self._answer(),
            *(self._errors(verdict.gap) if verdict.gap else ()),
            *self._after_net(),
            *map(cause_sentence, verdict.main_causes),
            *self._minor(),
            *map(variation_sentence, verdict.variations),
            *self._unexplained(),
            f"Next: {self._next_step()}",
        ]

    @property
    def details(self) -> list[str]:
        """Where the gap arises, what the shots can show, and how an amended scene flies."""
        handed = self.handed.sentences if self.handed else ()
        return [*self._phases(), *self._growth(), self._detection(), *handed]

    def _answer(self) -> str:
        shots = f"{len(self.measured.shots)} shots of {self.measured.name}"
        differ = f"{shots} differ from the simulator {self.simulator_name}"
        return {
            "no_gap": f"{answer_title(self.verdict)}: {shots} agree with the simulator "
            f"{self.simulator_name} down to the minimum detectable effects (5.8 sigma).",
            "named": f"Named: {differ}; {self._counts()} identified.",
            "ambiguous": f"Ambiguous: {differ}; {self._counts()} found, but not all are "
            "identified uniquely.",
            "unknown": f"Unknown: {differ}; the effects of the catalogue do not explain the "
            "difference.",
        }[self.verdict.verdict]

    def _counts(self) -> str:
        roles = Counter(cause.role for cause in self.verdict.main_causes)
        return " and ".join(counted(count, ROLES[role]) for role, count in roles.items())

    def _minor(self) -> Iterator[str]:
        minor = minor_causes(self.verdict)
        if minor:
            names = listed([cause.identity for cause in minor])
            share = percent(sum(cause.gap_share for cause in minor))
            yield f"Minor structure, not amended: {names}; {share} of the gap."

    def _unexplained(self) -> Iterator[str]:
        unexplained = self.verdict.unexplained
        if unexplained.phase:
            place = PLACES[unexplained.phase]
            yield f"Unexplained structure {place}: {percent(unexplained.share)} of the gap."
            yield f"Candidate formula for it, not a cause: {unexplained.formula}."

    def _phases(self) -> Iterator[str]:
        shares = self.verdict.phases
        if any(shares.model_dump().values()):
            parts = [
                f"{percent(getattr(shares, phase))} {place}" for phase, place in PLACES.items()
            ]
            yield f"The gap arises {', '.join(parts[:2])} and {parts[2]}."

    def _growth(self) -> Iterator[str]:
        located = self.verdict.located
        if located and located.growth and located.growth[0].p_value <= SIGNIFICANT:
            first = located.growth[0]
            yield (
                f"The trajectory discrepancy depends most on {first.covariate}, which explains "
                f"{percent(first.share)} of its variance ({p_text(first.p_value)})."
            )

    def _errors(self, gap: Gap) -> Iterator[str]:
        reached = [k for k, ms in enumerate(gap.horizons_ms) if ms <= TYPICAL_MS]
        k = max(reached, default=0)
        sizes = [f"{values[k]:.1f} mm" for values in (gap.before_mm, gap.after_mm, gap.floor_mm)]
        what = f"Prediction error on held-out shots, {gap.horizons_ms[k]} ms ahead"
        yield self._compared(what, *sizes)
        if gap.landing:
            sizes = [f"{place:.1f} mm and {time:.2f} ms" for place, time in gap.landing.sizes]
            yield self._compared("Prediction error at landing", *sizes)

    def _after_net(self) -> Iterator[str]:
        net = self.verdict.net
        if net:
            what = f"Prediction error up to {net.horizon_ms} ms after the net"
            sizes = f"{net.before_mm:.1f} mm before, {net.after_mm:.1f} mm after amending"
            yield f"{what}: {sizes} ({counted(net.held_out, 'held-out contact')})."

    def _compared(self, what: str, before: str, after: str, floor: str) -> str:
        sizes = f"{before} before, {after} after amending" if self.verdict.main_causes else before
        return f"{what}: {sizes}; prediction floor {floor}."

    def _detection(self) -> str:
        shown, hidden = len(self.verdict.minimum_detectable), self.verdict.not_identifiable
        text = f"Identifiable from these shots: {shown} of {shown + len(hidden)} parameters"
        return f"{text}; not {', '.join(hidden)}." if hidden else f"{text}."

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
