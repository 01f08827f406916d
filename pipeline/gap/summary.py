"""Findings: a verdict with what it is about, and what it says in words."""

from collections.abc import Iterator
from dataclasses import dataclass

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.gap.diagnose import Sight
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.verdict import Cause, Gap, Verdict, label_of
from models.gap.verify.limitations import experiment
from pipeline.gap.measured_shots import MeasuredShots
from pipeline.gap.wording import PLACES, chance, label, number, percent, with_unit

TYPICAL_MS = 200  # the horizon that is spoken of, where shots are that long
TELLING = 0.05  # chance up to which an axis is spoken of


@dataclass(frozen=True)
class Findings:
    """What was found.

    Attributes:
        measured: the shots.
        simulator: that they were compared with.
        called: how the user calls it.
        level: chance of a false name where there is no gap.
        verdict: on them.
    """

    measured: MeasuredShots
    simulator: Simulator
    called: str
    level: float
    verdict: Verdict

    @property
    def numbers(self) -> dict[str, Hypothesis]:
        """Every number in question by its label, such as ``wind.x``."""
        return numbers(self.simulator)

    @property
    def sentences(self) -> list[str]:
        """The verdict in a few plain sentences, the most important first."""
        return [
            self._answer(),
            *(self._cause(one) for one in self.verdict.effects),
            *self._unexplained(),
            *self._where(),
            *self._growth(),
            *(self._errors(self.verdict.gap) if self.verdict.gap else ()),
            *self._refused(),
            self._sight(),
        ]

    def title(self, name: str) -> str:
        """Return in words what the number with a label is about."""
        return catalogue()[self.numbers[name].effect].title

    def splits(self, cause: Cause) -> str:
        """Return the experiment that tells a cause from the others of its class, if any."""
        return experiment(cause, self.measured.shots) if len(cause.possible) > 1 else ""

    def _answer(self) -> str:
        shots = f"{len(self.measured.shots)} shots of {self.measured.name}"
        causes = len(self.verdict.effects)
        several = "one cause" if causes == 1 else f"{causes} causes"
        doubtful = "which has" if causes == 1 else "of which some have"
        return {
            "no_gap": f"No gap: {shots} agree with {self.called} as far as they can tell.",
            "named": f"Named: {shots} differ from {self.called} by {several}.",
            "ambiguous": f"Ambiguous: {shots} differ from {self.called} by {several}, "
            f"{doubtful} more than one possible name.",
            "unknown": f"Unknown: {shots} differ from {self.called} by something that no effect "
            "of the catalogue explains.",
        }[self.verdict.verdict]

    def _cause(self, cause: Cause) -> str:
        low, high = (number(value) for value in cause.interval)
        found = f"{with_unit(cause.estimate, cause.unit)} (95 %: {low} to {high})"
        share = f"{percent(cause.gap_share)} of the gap"
        others = ", ".join(cause.others)
        doubt = f" It could also be {others}; to decide, {self.splits(cause)}." if others else ""
        if cause.kind == "missing_effect":
            return f"{self._called(cause)} is missing: {found}, {share}.{doubt}"
        return f"{self._called(cause)} is {found} and not {number(cause.nominal)}, {share}.{doubt}"

    def _called(self, cause: Cause) -> str:
        return f"{label(cause)} ({self.title(label(cause))})"

    def _unexplained(self) -> Iterator[str]:
        left = self.verdict.unexplained
        if left.where:
            place = PLACES[left.where]
            yield f"What has no name acts {place}, {percent(left.share)} of the gap."
            yield f"A lead and not a name: {left.lead}."

    def _where(self) -> Iterator[str]:
        shares = self.verdict.where.model_dump()
        if any(shares.values()):
            parts = [f"{percent(share)} {PLACES[place]}" for place, share in shares.items()]
            yield f"The gap arises {', '.join(parts[:2])} and {parts[2]}."

    def _growth(self) -> Iterator[str]:
        located = self.verdict.located
        if located and located.growth and located.growth[0].p_value <= TELLING:
            most = located.growth[0]
            yield (
                f"How far balls part differs most with the {most.axis}: {percent(most.share)} of "
                f"its variance, {chance(most.p_value)}."
            )

    def _errors(self, gap: Gap) -> Iterator[str]:
        reached = [k for k, ms in enumerate(gap.horizons_ms) if ms <= TYPICAL_MS]
        k = max(reached, default=0)
        before, after, floor = (
            f"{values[k]:.1f} mm" for values in (gap.before_mm, gap.after_mm, gap.floor_mm)
        )
        when = f"Predictions {gap.horizons_ms[k]} ms ahead of shots that naming never saw err"
        yield self._compared(when, before, after, floor)
        if gap.landing:
            before, after, floor = (
                f"{place:.1f} mm and {time:.2f} ms" for place, time in gap.landing.sizes
            )
            yield self._compared("Where and when they land, predictions err", before, after, floor)

    def _compared(self, what: str, before: str, after: str, floor: str) -> str:
        without = f"without any gap they would err by {floor}"
        if not self.verdict.effects:
            return f"{what} by {before}; {without}."
        return (
            f"{what} by {after} with the amended simulator, by {before} with the one as it was; "
            f"{without}."
        )

    def _refused(self) -> Iterator[str]:
        if self.verdict.gap and self.verdict.gap.worse:
            yield (
                "With these causes the simulator predicts worse than before, so they are not "
                "believed: amended.yaml is the simulator as it was."
            )

    def _sight(self) -> str:
        shown, blind = len(self.verdict.detectable), self.verdict.blind_to
        sight = f"Of {shown + len(blind)} numbers in question these shots can show {shown}"
        return f"{sight}; they are blind to {', '.join(blind)}." if blind else f"{sight}."


def numbers(simulator: Simulator) -> dict[str, Hypothesis]:
    """Return every number in question by its label, such as ``wind.x``."""
    return {label_of(one): one for one in hypotheses(simulator)}


def sight_lines(measured: MeasuredShots, simulator: Simulator, sight: Sight) -> Iterator[str]:
    """Yield in words what shots can show, before anything is looked for in them."""
    sizes, blind = sight
    known, width = numbers(simulator), max(map(len, sizes), default=0)
    yield f"{len(measured.shots)} shots of {measured.name} can show, from this size on:"
    for name, size in sizes.items():
        yield f"  {name:<{width}}  {with_unit(size, known[name].declaration.unit)}"
    if blind:
        yield f"They are blind to {', '.join(blind)}."
