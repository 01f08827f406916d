"""A verdict in sentences, for the terminal and the top of the page."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Cause, DetectionLimits, Gap, Variation, Verdict
from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.gap.measured_shots import MeasuredShots
from rallygap.pipeline.gap.next_step import next_step
from rallygap.pipeline.gap.reservations import reservations
from rallygap.pipeline.gap.wording import (
    PLACES,
    ROLES,
    counted,
    interval_text,
    listed,
    p_text,
    percent,
    worth_text,
)
from rallygap.pipeline.web.numbers import number, with_unit

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.amended_scene import AmendedScene

TYPICAL_MS = 200  # the horizon of the summary, where shots are that long
SIGNIFICANT = 0.05  # p-value up to which a covariate is reported


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
        handed: what is given back where the simulator is a scene of MuJoCo.
    """

    measured: MeasuredShots
    simulator: Simulator
    simulator_name: str
    settings: GapSettings
    verdict: Verdict
    balls: Expected
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
            f"Next: {next_step(verdict, self.measured.shots, self.settings)}",
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
            parts = [f"{percent(getattr(shares, one))} {place}" for one, place in PLACES.items()]
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


def answer_title(verdict: Verdict) -> str:
    """Return the answer in a few words."""
    title = verdict.verdict.replace("_", " ").capitalize()
    no_gap_but = verdict.verdict == "no_gap" and minor_causes(verdict)
    return f"{title} but for minor structure" if no_gap_but else title


def minor_causes(verdict: Verdict) -> list[Cause]:
    """Return the causes that are minor structure."""
    return [cause for cause in verdict.causes if cause.role == "minor"]


def cause_sentence(cause: Cause) -> str:
    """Return a cause with its estimate, share and worth."""
    found = f"{with_unit(cause.estimate, cause.unit)} (95 % {interval_text(cause.interval)})"
    missing = cause.kind == "missing_effect"
    before = "missing in the simulator" if missing else f"simulator {number(cause.nominal)}"
    share = f"{percent(cause.gap_share)} of the gap"
    worth = f"; without it predictions err {worth_text(cause.worth)}" if cause.worth else ""
    others = f" Not separable from {listed(cause.alternatives)}." if cause.alternatives else ""
    return (
        f"{ROLES[cause.role].capitalize()} {cause.identity} ({title(cause.identity)}): "
        f"estimate {found}, {before}; {share}{worth}.{others}"
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


def title(identity: str) -> str:
    """Return the catalogue's description of the effect of a parameter."""
    return catalogue()[Hypothesis.from_identity(identity).effect].title


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
