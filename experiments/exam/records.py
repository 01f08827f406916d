"""Exam records: one a question, with its truth and what every method answered.

The scoring path writes them after all methods have answered. All rates, tables and figures of the
exam follow from them.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from experiments.exam.interface import NamedCause, Number, Record
from experiments.exam.simulate.trial import Dynamics, SpinLabels
from rallygap.models.gap.verdict import Answer as Conclusion
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.runtime.errors import InputError

RECORDS = Path("reports") / "exam" / "records.jsonl"  # of the whole exam, in the repository


class HiddenCause(Record):
    """One parameter in which the environment of a question differs from the nominal simulator."""

    identity: str  # effect.parameter, such as wind.x
    kind: Literal["wrong_value", "missing_effect"]  # whether the nominal simulator lists the effect
    nominal: Number  # its value there, neutral where the effect is not listed
    # the true one; of independent dynamics, what a best fit of the catalogue's form finds
    value: Number
    # identities of parameters that explain the data as well: with one of them free, less than the
    # detection limit is left of the cause
    indistinguishable: tuple[str, ...]
    # of several causes: gap between the environment with and without this one, mm
    effect_mm: Number | None = None


class AnswerRecord(Record):
    """What a method answered."""

    # no_gap, named, ambiguous or unknown; None where the method failed
    conclusion: Conclusion | None
    causes: tuple[NamedCause, ...] = ()  # that it named
    error: str | None = None  # why it failed
    gap_after_mm: Number | None = None  # gap between its amended simulator and the environment, mm


class ExamRecord(Record):
    """A question, its truth and the answers."""

    name: str  # of the trial
    group: str  # the purpose of the question
    cell: str  # a part of the group, such as one of the sweeps; empty where it has no parts
    dynamics: Dynamics  # which equations the balls follow
    multiple: Number  # size of a cause, in detection limits
    shots: int  # how many are recorded
    noise: Number  # standard deviation of a coordinate, m
    spin_labels: SpinLabels  # none, one a shot or one a row
    directions: Literal[1, 2]  # in which balls are shot
    withheld: tuple[str, ...]  # effects that are removed from the catalogue
    parameters: tuple[str, ...]  # identities of the parameters to hide
    not_posed: str | None = None  # why the question could not be posed, if it could not
    hidden: tuple[HiddenCause, ...] = ()  # the truth
    # gap between the nominal simulator and the environment, mm; None where nothing is hidden
    gap_before_mm: Number | None = None
    answers: dict[str, AnswerRecord] = Field(default={})  # by method
    seconds: dict[str, Number] = Field(default={})  # CPU time of each method


def write_records(path: Path, records: Sequence[ExamRecord]) -> None:
    """Write records, one a line."""
    lines = (record.model_dump_json(exclude_defaults=True) for record in records)
    write_text(path, "".join(f"{line}\n" for line in lines))


def read_records(path: Path) -> list[ExamRecord]:
    """Read records that ``write_records`` wrote.

    Raises:
        InputError: there is no such file, it is empty, or a line of it is not a record.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise InputError(
            path, "there is no such file; run `python -m experiments.stages.exam`"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read as text: {error}") from None
    if not lines:
        raise InputError(path, "has no record; run `python -m experiments.stages.exam`")
    records = []
    for row, line in enumerate(lines, start=1):
        try:
            records.append(ExamRecord.model_validate_json(line))
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(str(part) for part in first["loc"]) or None
            problem = f"{first['msg']}; run `python -m experiments.stages.exam`"
            raise InputError(path, problem, row=row, field=field) from None
    return records
