"""What counts as right in the robustness groups (docs/exam.md).

- *Named* are all causes of an answer that are not minor. Where the sensor has errors of its own,
  faults of the sensor are left out: they are neither right nor wrong.
- A *clean set* has no physical cause, and the right answer names none.
- A cause that *varies* over the session is no constant of the catalogue. The right answer is that
  there is a gap (any but ``no_gap``), without a cause of another effect.
- The *leading cause* is the hidden one, of several that with the largest effect on trajectories.
"""

from collections.abc import Iterable

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.exam.design.robustness import FAULTY_SENSOR, GROUPS, VARYING
from rallygap.models.exam.interface import NamedCause
from rallygap.models.exam.records import AnswerRecord, ExamRecord, HiddenCause


def of_sweeps(records: Iterable[ExamRecord]) -> list[ExamRecord]:
    """Return the records of all groups but the robustness groups."""
    return [record for record in records if record.group not in GROUPS]


def of_robustness(records: Iterable[ExamRecord]) -> list[ExamRecord]:
    """Return the records of the robustness groups."""
    return [record for record in records if record.group in GROUPS]


def varies(record: ExamRecord) -> bool:
    """Return whether the hidden cause is not the same throughout the session."""
    return record.group in VARYING and bool(record.hidden)


def named(record: ExamRecord, answer: AnswerRecord) -> tuple[NamedCause, ...]:
    """Return the causes that an answer names."""
    ignored = record.group in FAULTY_SENSOR
    return tuple(
        cause
        for cause in answer.causes
        if cause.role != "minor" and not (ignored and not physical(cause))
    )


def physical(cause: NamedCause) -> bool:
    """Return whether a cause is one of flight or table."""
    known = catalogue().get(cause.identity.partition(".")[0])
    return cause.role != "sensor" and (known is None or known.acts != "sensor")


def names_physical_cause(record: ExamRecord, answer: AnswerRecord) -> bool:
    """Return whether an answer names a cause of flight or table."""
    return any(physical(cause) for cause in named(record, answer))


def admits_varying_cause(record: ExamRecord, answer: AnswerRecord) -> bool:
    """Return whether an answer is right where a cause varies."""
    effects = {hidden.identity.partition(".")[0] for hidden in record.hidden}
    others = {cause.identity.partition(".")[0] for cause in named(record, answer)} - effects
    return answer.conclusion != "no_gap" and not others


def leading(record: ExamRecord) -> HiddenCause:
    """Return the leading cause of a record that hides one or more."""
    return max(record.hidden, key=lambda hidden: hidden.effect_mm or 0.0)
