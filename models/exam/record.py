"""Sheets: one for each question, with its truth and what every method answered.

They are written by the scoring path, after all methods have answered, and hold all that the
figures of the exam follow from. Numbers have six digits: more would only show the processor's last
bits.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict

from models.exam.answer import Answer
from models.exam.design.trial import SpinLabels, World


def rounded(value: float) -> float:
    """Return six digits of a number."""
    return float(f"{value:.6g}")


Number = Annotated[float, AfterValidator(rounded)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Hidden(_Part):
    """One number in which the hall of a question differs from the nominal simulator.

    Attributes:
        name: as a verdict calls it.
        effect: the catalogue's.
        parameter: of the effect.
        kind: whether the nominal simulator lists the effect.
        nominal: its value there, neutral where it does not.
        value: the truth.
        alike: names of what may stand in for it: in its place any of them leaves less than could be
            detected. None, and it is a class of its own on these data.
    """

    name: str
    effect: str
    parameter: str
    kind: Literal["wrong_value", "missing_effect"]
    nominal: Number
    value: Number
    alike: tuple[str, ...]


class Named(_Part):
    """One cause that a method named, as in ``models.exam.answer.Found``."""

    name: str
    effect: str
    parameter: str
    estimate: Number
    interval: tuple[Number, Number] | None
    possible: tuple[str, ...]


class Answered(_Part):
    """What a method answered.

    Attributes:
        answer: in one word; None where the method failed.
        causes: that it named.
        error: why it failed.
        after_mm: the gap that is left between its amended simulator and the hall, see ``Sheet``.
    """

    answer: Answer | None
    causes: tuple[Named, ...] = ()
    error: str | None = None
    after_mm: Number | None = None


class Sheet(_Part):
    """A question, its truth and the answers.

    Attributes:
        name: of the trial.
        group: what the question is for.
        cell: of the sweeps; empty in other groups.
        world: whose equations the balls followed.
        multiple: of the detectable size that was asked for.
        shots: how many were recorded.
        noise: of a coordinate, m.
        spin_labels: none, one a shot or one a row.
        directions: in which balls were shot.
        withheld: effects that were not in question.
        asked: the parameters to hide, such as ``wind.x``.
        not_posed: why the question could not be posed, if it could not.
        hidden: the truth.
        before_mm: gap between the nominal simulator and the hall, mm; none where nothing is hidden.
        answers: by method.
    """

    name: str
    group: str
    cell: str
    world: World
    multiple: Number
    shots: int
    noise: Number
    spin_labels: SpinLabels
    directions: Literal[1, 2]
    withheld: tuple[str, ...]
    asked: tuple[str, ...]
    not_posed: str | None = None
    hidden: tuple[Hidden, ...] = ()
    before_mm: Number | None = None
    answers: dict[str, Answered] = {}
