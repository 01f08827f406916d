"""Folds of measured sets: what is diagnosed, and the simulator that errors are planted in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from numpy import int64
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.fit.shots import Shots
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.known_answers.answers import Diagnosis, verdicts
from rallygap.pipeline.known_answers.design import Question

NOMINAL = "literature"  # simulator that the base simulators are amended from


@dataclass(frozen=True)
class MeasuredSet:
    """A measured set in folds.

    Attributes:
        name: of the set and of its adapter.
        shots: all of them.
        fold: (B,) number of the fold of each shot.
        folds: how many there are.
        fingerprint: of all that its verdicts depend on.
        folder: of its verdicts.
    """

    name: str
    shots: Shots
    fold: NDArray[int64]
    folds: int
    fingerprint: str
    folder: Path


@dataclass(frozen=True)
class Fold:
    """One part of the recordings of a measured set.

    Attributes:
        set: name of the measured set.
        number: from 0.
        shots: of the part.
        base: the nominal simulator as amended by the other parts.
        folder: of the verdicts.
    """

    set: str
    number: int
    shots: Shots
    base: Simulator
    folder: Path

    @property
    def unplanted(self) -> Question:
        """The question in which no error is planted."""
        return Question(self.set, self.number)

    def diagnosis(self, question: Question, references: Mapping[str, float]) -> Diagnosis:
        """Return the diagnosis that answers a question; errors are planted about ``references``."""
        file = self.folder / f"{question.name}.json"
        return Diagnosis(file, self.shots, self.base, question.error, references, question.seed)

    def before_planting(self) -> Diagnosis:
        """Return the diagnosis that reference values are found by."""
        return Diagnosis(self.folder / f"{self.number}.references.json", self.shots, self.base)


def folds_of(sets: Sequence[MeasuredSet]) -> list[Fold]:
    """Return all folds of all sets; their base simulators are found first."""
    nominal = load_simulator(NOMINAL)
    places = [(one, number) for one in sets for number in range(one.folds)]
    others = [
        Diagnosis(one.folder / f"{number}.base.json", one.shots[one.fold != number], nominal)
        for one, number in places
    ]
    return [
        Fold(one.name, k, one.shots[one.fold == k], amended(nominal, verdict), one.folder)
        for (one, k), verdict in zip(places, verdicts(others, "base simulators"), strict=True)
    ]
