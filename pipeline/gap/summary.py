"""A verdict in sentences, for the terminal and the top of the page."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.gap.hypotheses import Hypothesis
from models.gap.settings import GapSettings
from models.gap.verdict import Cause, DetectionLimits, Gap, Verdict
from models.gap.verify.limitations import experiment
from pipeline.gap.measured_shots import MeasuredShots
from pipeline.gap.wording import PLACES, interval_text, number, p_text, percent, with_unit

TYPICAL_MS = 200  # the horizon of the summary, where shots are that long
MOST_LISTED = 3  # identities in a sentence; the limitations list all
SIGNIFICANT = 0.05  # p-value up to which a covariate is reported


@dataclass(frozen=True)
class Findings:
    """A verdict with its data, its nominal simulator under the user's name, and its settings."""

    measured: MeasuredShots
    simulator: Simulator
    simulator_name: str
    settings: GapSettings
    verdict: Verdict

    @property
    def sentences(self) -> list[str]:
        """The verdict in sentences, the most important first."""
        return [
            self._answer(),
            *map(self._cause, self.verdict.causes),
            *self._unexplained(),
            *self._phases(),
            *self._growth(),
            *(self._errors(self.verdict.gap) if self.verdict.gap else ()),
            self._detection(),
        ]

    def separating_experiment(self, cause: Cause) -> str:
        """Return the experiment that separates a cause from its alternatives; empty without any."""
        if not cause.alternatives:
            return ""
        return experiment(cause, self.measured.shots, self.settings)

    def _answer(self) -> str:
        shots = f"{len(self.measured.shots)} shots of {self.measured.name}"
        count = len(self.verdict.causes)
        causes = "one cause" if count == 1 else f"{count} causes"
        differ = f"{shots} differ from the simulator {self.simulator_name}"
        return {
            "no_gap": f"No gap: {shots} agree with the simulator {self.simulator_name} within "
            "measurement noise.",
            "named": f"Named: {differ}; {causes} identified.",
            "ambiguous": f"Ambiguous: {differ}; {causes} found, but not all are identified "
            "uniquely.",
            "unknown": f"Unknown: {differ}; no effect of the catalogue explains the difference.",
        }[self.verdict.verdict]

    def _cause(self, cause: Cause) -> str:
        found = f"{with_unit(cause.estimate, cause.unit)} (95 % {interval_text(cause.interval)})"
        before = (
            "missing in the simulator"
            if cause.kind == "missing_effect"
            else f"simulator {number(cause.nominal)}"
        )
        text = (
            f"{cause.identity} ({title(cause.identity)}): estimate {found}, {before}; "
            f"{percent(cause.gap_share)} of the gap."
        )
        if not cause.alternatives:
            return text
        return f"{text} Not separable from {_listed(cause.alternatives)}."

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
        yield self._compared(f"Prediction error on held-out shots, {gap.horizons_ms[k]} ms", *sizes)
        if gap.landing:
            sizes = [f"{place:.1f} mm and {time:.2f} ms" for place, time in gap.landing.sizes]
            yield self._compared("Landing prediction error (position and time)", *sizes)

    def _compared(self, what: str, before: str, after: str, floor: str) -> str:
        amended = f", {after} with the amended one" if self.verdict.causes else ""
        return f"{what}: {before} with the nominal simulator{amended}; prediction floor {floor}."

    def _detection(self) -> str:
        shown, hidden = len(self.verdict.minimum_detectable), self.verdict.not_identifiable
        text = f"Identifiable from these shots: {shown} of {shown + len(hidden)} parameters"
        return f"{text}; not {', '.join(hidden)}." if hidden else f"{text}."


def title(identity: str) -> str:
    """Return the catalogue's description of the effect of a parameter."""
    return catalogue()[Hypothesis.from_identity(identity).effect].title


def _listed(identities: Sequence[str]) -> str:
    if len(identities) > MOST_LISTED:
        return f"{len(identities)} other parameters"
    return ", ".join(identities)


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
