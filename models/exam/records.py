"""Exam records: one a question, with its truth and what every method answered.

The scoring path writes them after all methods have answered. All rates, tables and figures of the
exam follow from them.
"""

from typing import Literal

from pydantic import Field

from models.exam.interface import NamedCause, Number, Record
from models.exam.simulate.trial import Dynamics, SpinLabels
from models.gap.verdict import Answer as Conclusion


class HiddenCause(Record):
    """One parameter in which the environment of a question differs from the nominal simulator.

    Attributes:
        identity: ``effect.parameter``, such as ``wind.x``.
        kind: whether the nominal simulator lists the effect.
        nominal: its value there, neutral where the effect is not listed.
        value: the true one; of independent dynamics, what a best fit of the catalogue's form finds.
        indistinguishable: identities of parameters that explain the data as well: with one of them
            free, less than the detection limit is left of the cause.
    """

    identity: str
    kind: Literal["wrong_value", "missing_effect"]
    nominal: Number
    value: Number
    indistinguishable: tuple[str, ...]


class AnswerRecord(Record):
    """What a method answered.

    Attributes:
        conclusion: no_gap, named, ambiguous or unknown; None where the method failed.
        causes: that it named.
        error: why it failed.
        gap_after_mm: gap between its amended simulator and the environment, mm.
    """

    conclusion: Conclusion | None
    causes: tuple[NamedCause, ...] = ()
    error: str | None = None
    gap_after_mm: Number | None = None


class ExamRecord(Record):
    """A question, its truth and the answers.

    Attributes:
        name: of the trial.
        group: the purpose of the question.
        cell: of the sweeps; empty in other groups.
        dynamics: which equations the balls follow.
        multiple: size of a cause, in detection limits.
        shots: how many are recorded.
        noise: standard deviation of a coordinate, m.
        spin_labels: none, one a shot or one a row.
        directions: in which balls are shot.
        withheld: effects that are removed from the catalogue.
        parameters: identities of the parameters to hide.
        not_posed: why the question could not be posed, if it could not.
        hidden: the truth.
        gap_before_mm: gap between the nominal simulator and the environment, mm; None where
            nothing is hidden.
        answers: by method.
    """

    name: str
    group: str
    cell: str
    dynamics: Dynamics
    multiple: Number
    shots: int
    noise: Number
    spin_labels: SpinLabels
    directions: Literal[1, 2]
    withheld: tuple[str, ...]
    parameters: tuple[str, ...]
    not_posed: str | None = None
    hidden: tuple[HiddenCause, ...] = ()
    gap_before_mm: Number | None = None
    answers: dict[str, AnswerRecord] = Field(default={})
