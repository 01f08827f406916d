"""Marks and rates from exam records.

- *Distinguishable*: no other parameter explains a hidden cause as well on its data. Components of a
  vector, such as the wind's, count as one quantity.
- *Right*: the answer is ``named``, with exactly the hidden causes. On a clean set: ``no_gap``. With
  a withheld effect: ``unknown``.
- *Ambiguous*: as many causes as are hidden, each hidden one among the possible ones of another.
- *Missed*: ``no_gap``, although something is hidden. *Failed*: the method raised an error. *Wrong*:
  all other answers.
- *Solved*: each hidden cause is named if it is distinguishable, otherwise it is among the possible
  ones of a cause, and no other cause is named. Clean sets and withheld effects: *right*.
- *False alarm*: any answer but ``no_gap`` on a set of the group ``clean``. A method that fails is
  wrong everywhere.
- *Coverage*: of all parameters at 3 detection limits or more that are named correctly, in answers
  without any wrong cause, the share whose 95 % interval contains the true value.
- The robustness groups have rates of their own. *Named* are all causes of an answer that are not
  minor. Where the sensor has errors of its own, faults of the sensor are left out: they are neither
  right nor wrong. A *clean set* has no physical cause, and the right answer names none. A cause
  that *varies* over the session is no constant of the catalogue: the right answer is that there is
  a gap (any but ``no_gap``), without a cause of another effect. The *leading cause* is the hidden
  one, of several that with the largest effect on trajectories.
- *Removable gap closed*: over all trials with a cause that can be named, the sum of the
  reductions of the gap by amended simulators, divided by the sum of the gaps (runner.py).
  The reduction of a method that fails is zero.

A rate without any trial is None.
"""

from collections.abc import Callable, Iterable, Sequence
from itertools import permutations
from typing import Any, Literal

from scipy.stats import binomtest

from experiments.exam.design.question import MULTIPLE
from experiments.exam.design.questions import BASE
from experiments.exam.design.robustness import FAULTY_SENSOR, GROUPS, VARYING
from experiments.exam.interface import NamedCause, rounded
from experiments.exam.records import AnswerRecord, ExamRecord, HiddenCause
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.gap.hypotheses import Hypothesis

Mark = Literal["right", "ambiguous", "wrong", "missed", "failed"]
MARKS: tuple[Mark, ...] = ("right", "ambiguous", "wrong", "missed", "failed")


def of_sweeps(records: Iterable[ExamRecord]) -> list[ExamRecord]:
    """Return the records of all groups but the robustness groups."""
    return [record for record in records if record.group not in GROUPS]


def of_robustness(records: Iterable[ExamRecord]) -> list[ExamRecord]:
    """Return the records of the robustness groups."""
    return [record for record in records if record.group in GROUPS]


def varies(record: ExamRecord) -> bool:
    """Return whether the hidden cause is not the same throughout the session."""
    return record.group in VARYING and bool(record.hidden)


def answered(records: Iterable[ExamRecord], method: str) -> list[ExamRecord]:
    """Return the records of questions that a method was given."""
    return [record for record in records if method in record.answers]


def of_base(records: Iterable[ExamRecord]) -> list[ExamRecord]:
    """Return the records of the sweeps' base: 3 detection limits, 100 shots, 3 mm."""
    return [record for record in records if record.cell == BASE.name]


def of_group(records: Iterable[ExamRecord], group: str) -> list[ExamRecord]:
    """Return the records of a group."""
    return [record for record in records if record.group == group]


def distinguishable(record: ExamRecord) -> bool:
    """Return whether the data distinguish every hidden cause from all other parameters."""
    return not any(hidden.indistinguishable for hidden in record.hidden)


def mark(record: ExamRecord, method: str) -> Mark:
    """Return the mark of a method's answer."""
    answer = record.answers[method]
    if answer.conclusion is None:
        return "failed"
    if _right(record, answer):
        return "right"
    if answer.conclusion == "no_gap":
        return "missed"
    constant = record.hidden and not record.withheld and not varies(record)
    can_be_named = constant and answer.conclusion != "unknown"
    return "ambiguous" if can_be_named and _match(record, answer, _is_possible) else "wrong"


def solved(record: ExamRecord, method: str) -> bool:
    """Return whether an answer says all that the data show, and nothing else."""
    answer = record.answers[method]
    if record.withheld or varies(record) or not record.hidden:
        return mark(record, method) == "right"
    return answer.conclusion in ("named", "ambiguous") and _match(record, answer, _solves)


def covered(records: Iterable[ExamRecord], method: str) -> list[bool]:
    """Return whether the interval of each correctly named parameter contains the true value."""
    contains = []
    for record in answered(records, method):
        answer = record.answers[method]
        unclear = record.multiple < MULTIPLE or record.withheld or varies(record)
        if unclear or not _exact(record, answer):
            continue
        truth = {hidden.identity: hidden.value for hidden in record.hidden}
        for cause in _named(record, answer):
            if cause.interval is not None:
                low, high = cause.interval
                contains.append(low <= truth[cause.identity] <= high)
    return contains


def removable_gap(records: Iterable[ExamRecord], method: str) -> tuple[int, float, float]:
    """Return the number of trials with a gap to close, and its sums before and after in mm."""
    gaps = [
        (record.gap_before_mm, record.answers[method].gap_after_mm)
        for record in answered(records, method)
        if record.gap_before_mm is not None and not record.withheld
    ]
    after = sum(before if after is None else after for before, after in gaps)
    return len(gaps), sum(before for before, _ in gaps), after


def interval(part: int, whole: int) -> tuple[float, float]:
    """Return the Clopper-Pearson 95 % interval of a share."""
    ends = binomtest(part, whole).proportion_ci(0.95, "exact")
    return float(ends.low), float(ends.high)


def rates(records: Sequence[ExamRecord], method: str) -> dict[str, Any]:
    """Return all rates of a method, each after its counts, those of robustness groups last."""
    given = answered(of_sweeps(records), method)
    false_alarms = [mark(record, method) != "right" for record in of_group(given, "clean")]
    upper = None
    if false_alarms:
        # One-sided: with 95 % confidence the rate is no larger.
        test = binomtest(sum(false_alarms), len(false_alarms), alternative="less")
        upper = rounded(float(test.proportion_ci(0.95, "exact").high))

    def of_solved(questions: list[ExamRecord], counted: str, rate: str) -> dict[str, Any]:
        flags = [solved(record, method) for record in questions]
        return _counts(flags, counted, f"{counted}_right", rate)

    base = of_base(given)
    clear = [record for record in base if distinguishable(record)]
    other = [record for record in base if not distinguishable(record)]
    gaps, before, after = removable_gap(given, method)
    return {
        "trials": len(given),
        "failures": sum(mark(record, method) == "failed" for record in given),
        **_counts(false_alarms, "clean_sets", "false_alarms", "false_alarm_rate"),
        "false_alarm_upper95": upper,
        **of_solved(clear, "distinguishable", "top1_at_3x"),
        **of_solved(other, "indistinguishable", "class_at_3x"),
        **of_solved(of_group(given, "pair"), "pairs", "pairs_both"),
        **of_solved(of_group(given, "withheld"), "withheld", "unknown_recall"),
        **_counts(covered(given, method), "intervals", "intervals_right", "coverage"),
        "gaps": gaps,
        "gap_before_mm": rounded(before),
        "gap_after_mm": rounded(after),
        "removable_closed": removable_closed(given, method),
        **_robustness(answered(of_robustness(records), method), method),
    }


def removable_closed(records: Iterable[ExamRecord], method: str) -> float | None:
    """Return the share of the removable gap that a method closes."""
    _, before, after = removable_gap(records, method)
    return rounded((before - after) / before) if before else None


def _robustness(given: Sequence[ExamRecord], method: str) -> dict[str, Any]:
    """Return the rates of the robustness groups."""
    clean = [record for record in given if not record.hidden]
    varying = [record for record in given if varies(record)]
    large = [record for record in given if record.hidden and record.multiple >= MULTIPLE]
    constant = [record for record in large if not varies(record)]
    false = [mark(record, method) != "right" for record in clean]
    leading = [_names_leading(record, record.answers[method]) for record in constant]
    exact = [solved(record, method) for record in constant]
    admitted = [mark(record, method) == "right" for record in varying]
    contains = covered(constant, method)
    return {
        **_counts(false, "clean_sets_new", "false_leading", "false_leading_rate"),
        **_counts(leading, "constant_new", "leading_right", "leading_at_3x"),
        **_counts(exact, "constant_new", "exact_right", "exact_at_3x"),
        **_counts(contains, "intervals_new", "intervals_new_right", "coverage_new"),
        **_counts(admitted, "varying_new", "varying_new_right", "unknown_recall_new"),
    }


def _counts(flags: Sequence[bool], counted: str, true: str, rate: str) -> dict[str, Any]:
    """Return the number of flags, of true ones, and their share, by these names."""
    share = rounded(sum(flags) / len(flags)) if flags else None
    return {counted: len(flags), true: sum(flags), rate: share}


def _named(record: ExamRecord, answer: AnswerRecord) -> list[NamedCause]:
    """Return the causes that an answer names."""
    ignored = record.group in FAULTY_SENSOR
    return [
        cause
        for cause in answer.causes
        if cause.role != "minor" and not (ignored and not _physical(cause))
    ]


def _physical(cause: NamedCause) -> bool:
    """Return whether a cause is one of flight or table."""
    effect = catalogue().get(_effect(cause))
    return cause.role != "sensor" and (effect is None or effect.acts != "sensor")


def _effect(cause: HiddenCause | NamedCause) -> str:
    return cause.identity.partition(".")[0]


def _right(record: ExamRecord, answer: AnswerRecord) -> bool:
    if varies(record):
        effects = {_effect(hidden) for hidden in record.hidden}
        others = {_effect(cause) for cause in _named(record, answer)} - effects
        return answer.conclusion != "no_gap" and not others
    if not record.hidden:
        physical = any(_physical(cause) for cause in _named(record, answer))
        return (record.group in GROUPS and not physical) or answer.conclusion == "no_gap"
    if record.withheld:
        return answer.conclusion == "unknown"
    return answer.conclusion == "named" and _exact(record, answer)


def _exact(record: ExamRecord, answer: AnswerRecord) -> bool:
    return answer.conclusion in ("named", "ambiguous") and _match(record, answer, _same)


def _match(
    record: ExamRecord, answer: AnswerRecord, fits: Callable[[HiddenCause, NamedCause], bool]
) -> bool:
    """Return whether the named causes fit the hidden ones, one to one."""
    causes = _named(record, answer)
    return len(causes) == len(record.hidden) and any(
        all(fits(hidden, cause) for hidden, cause in zip(record.hidden, order, strict=True))
        for order in permutations(causes)
    )


def _names_leading(record: ExamRecord, answer: AnswerRecord) -> bool:
    """Return whether the leading cause is among the named ones, by its class if it has one."""
    leading = max(record.hidden, key=lambda hidden: hidden.effect_mm or 0.0)
    fits = _is_possible if leading.indistinguishable else _same
    return any(fits(leading, cause) for cause in _named(record, answer))


def _same(hidden: HiddenCause, cause: NamedCause) -> bool:
    return hidden.identity == cause.identity


def _is_possible(hidden: HiddenCause, cause: NamedCause) -> bool:
    return _quantity(hidden.identity) in map(_quantity, cause.possible)


def _solves(hidden: HiddenCause, cause: NamedCause) -> bool:
    """Return whether a named cause says what the data show of a hidden one."""
    if hidden.indistinguishable:
        return _is_possible(hidden, cause)
    return _same(hidden, cause) and set(map(_quantity, cause.possible)) == {
        _quantity(hidden.identity)
    }


def _quantity(identity: str) -> str:
    return Hypothesis(*identity.split(".", 1)).quantity
