"""What the exam asks of a method, and what a method answers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from models.ball.simulator import Simulator
from models.exam.design.trial import Recording
from models.gap.fit.shots import Shots

Answer = Literal["no_gap", "named", "ambiguous", "unknown"]


@dataclass(frozen=True)
class Found:
    """One cause that a method names.

    Attributes:
        name: as in a verdict: of the effect, or of the number where an effect has several.
        effect: the catalogue's.
        parameter: of the effect.
        estimate: its value, in the parameter's unit.
        interval: 95 % of it; None where the method has none to give.
        possible: the names that the method does not tell from it, its own first.
    """

    name: str
    effect: str
    parameter: str
    estimate: float
    interval: tuple[float, float] | None
    possible: tuple[str, ...]


@dataclass(frozen=True)
class Finding:
    """What a method finds.

    Attributes:
        answer: in one word.
        causes: that it names.
        amended: the nominal simulator with the causes in it.
    """

    answer: Answer
    causes: tuple[Found, ...]
    amended: Simulator


# From recordings, the nominal simulator, and the effects that the catalogue does not have.
Method = Callable[[Sequence[Recording], Simulator, tuple[str, ...]], Finding]


def shots_of(recordings: Sequence[Recording]) -> Shots:
    """Return recordings as shots."""
    return Shots.from_arrays(
        [one.times for one in recordings],
        [one.positions for one in recordings],
        [one.labels for one in recordings],
        [one.label_times for one in recordings],
    )
