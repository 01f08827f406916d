"""Scores of answers: is the planted error among what the planting added to the verdict?"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.verdict import Cause, Verdict
from rallygap.pipeline.experiments.known_answers.design import DISTORTION, Question, true_values
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.web.numbers import interval_text, number

COLUMNS = [
    *("set", "fold", "place", "planted", "size", "value"),
    *("true", "verdict", "causes", "leading", "by_name", "exact", "covered", "false"),
    *("before_mm", "after_mm", "floor_mm"),
]


@dataclass(frozen=True)
class Answer:
    """The verdict on a question, with what its score needs.

    Attributes:
        question: that was asked.
        verdict: on it.
        unplanted: verdict on the unplanted question of the same fold.
        references: the fold's own values of parameters, by identity.
    """

    question: Question
    verdict: Verdict
    unplanted: Verdict
    references: Mapping[str, float]

    @property
    def is_planted(self) -> bool:
        """Whether an error is planted, rather than none."""
        return self.question.error is not None

    @property
    def is_distortion(self) -> bool:
        """Whether the planted error is a distortion, of which only the size is a parameter."""
        return self.question.error is not None and self.question.error.identity == DISTORTION

    @cached_property
    def truth(self) -> dict[str, float]:
        """Values by identity that a correct verdict finds besides those of the unplanted one."""
        return true_values(self.question.error, self.references) if self.question.error else {}

    @cached_property
    def new(self) -> tuple[Cause, ...]:
        """Main causes that the planting added: the unplanted verdict does not have them.

        Camera distortion is none of them: all real recordings have one, and how much of it is found
        depends on what else is.
        """
        before = {cause.identity: cause for cause in self.unplanted.main_causes}
        return tuple(
            cause
            for cause in self.verdict.main_causes
            if cause.identity != CAMERA.identity
            and not _same_departure(cause, before.get(cause.identity))
        )

    @property
    def false(self) -> tuple[Cause, ...]:
        """Leading causes among the new ones that are not what was planted."""
        return tuple(
            cause for cause in self.new if cause.role == "leading" and not self._planted(cause)
        )

    @property
    def leading(self) -> bool:
        """Whether the first new cause is what was planted, or not separable from it."""
        return bool(self.new) and self._planted(self.new[0])

    @property
    def by_name(self) -> bool:
        """Whether the first new cause is what was planted, not only one of its class."""
        return bool(self.new) and _quantity(self.new[0].identity) in map(_quantity, self.truth)

    @property
    def exact(self) -> bool:
        """Whether the planted error is leading, and there is no other new cause."""
        return self.leading and all(map(self._planted, self.new))

    @property
    def covered(self) -> tuple[bool, ...]:
        """Whether intervals of planted parameters contain the true values; one each that is new."""
        return tuple(
            cause.interval[0] <= self.truth[cause.identity] <= cause.interval[1]
            for cause in self.new
            if cause.identity in self.truth
        )

    def _planted(self, cause: Cause) -> bool:
        """Whether a cause is what was planted, by its quantity or one in its class."""
        return not {*map(_quantity, self.truth)}.isdisjoint(map(_quantity, cause.possible))


def set_scores(answers: Sequence[Answer]) -> dict[str, Any]:
    """Return the counts of one set's answers, and the coverage of intervals as a share.

    Questions with a distortion are counted apart: a correct verdict on one has no new leading
    cause.
    """
    planted = [answer for answer in answers if answer.is_planted and not answer.is_distortion]
    distorted = [answer for answer in answers if answer.is_distortion]
    unplanted = [answer.verdict for answer in answers if not answer.is_planted]
    covered = [inside for answer in planted for inside in answer.covered]
    return {
        "questions": len(planted),
        "leading": sum(answer.leading for answer in planted),
        "by_name": sum(answer.by_name for answer in planted),
        "exact": sum(answer.exact for answer in planted),
        "false_causes": sum(len(answer.false) for answer in planted),
        "intervals": len(covered),
        "covered": sum(covered),
        "coverage": rounded(sum(covered) / len(covered)) if covered else None,
        "distorted": len(distorted),
        "distorted_clean": sum(not answer.false for answer in distorted),
        "unplanted": len(unplanted),
        "unplanted_clean": sum(not verdict.leading for verdict in unplanted),
    }


def answer_table(answers: Sequence[Answer]) -> pd.DataFrame:
    """Return one row a question.

    ``value`` is what was planted, in the parameter's unit or m, ``true`` what a correct verdict
    finds, ``causes`` the main causes, each with the parameters that the shots cannot separate from
    it. Scores are empty where a question has none. Errors are means over the horizons.
    """
    return pd.DataFrame([_row(answer) for answer in answers], columns=COLUMNS)


def _row(answer: Answer) -> dict[str, Any]:
    question, verdict, error = answer.question, answer.verdict, answer.question.error
    row: dict[str, Any] = {
        "set": question.set,
        "fold": question.fold,
        "planted": "none",
        "verdict": verdict.verdict,
        "causes": "; ".join(map(_cause_text, verdict.main_causes)),
    }
    if error is not None:
        truth = (f"{identity} {number(value)}" for identity, value in answer.truth.items())
        row |= {
            "place": error.place,
            "planted": error.identity,
            "size": error.size,
            "value": error.value,
            "true": "; ".join(truth),
            "false": "; ".join(cause.identity for cause in answer.false),
        }
        if not answer.is_distortion:
            row |= {
                "leading": answer.leading,
                "by_name": answer.by_name,
                "exact": answer.exact,
                "covered": all(answer.covered) if answer.covered else None,
            }
    if verdict.gap:
        for name in ("before_mm", "after_mm", "floor_mm"):
            row[name] = float(np.mean(getattr(verdict.gap, name)))
    return row


def _cause_text(cause: Cause) -> str:
    estimate = f"{cause.identity} {number(cause.estimate)} ({interval_text(cause.interval)})"
    return " or ".join([estimate, *cause.alternatives])


def _same_departure(first: Cause, other: Cause | None) -> bool:
    """Whether two estimates depart as much from the nominal values: their intervals overlap."""
    if other is None:
        return False
    (low, high), (other_low, other_high) = (
        (cause.interval[0] - cause.nominal, cause.interval[1] - cause.nominal)
        for cause in (first, other)
    )
    return low <= other_high and other_low <= high


def _quantity(identity: str) -> str:
    return Hypothesis.from_identity(identity).quantity
