"""Scores of answers: is the planted error among what the planting added to the verdict?"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.verdict import Cause, Verdict
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.known_answers.design import DISTORTION, Question
from rallygap.pipeline.known_answers.planting import true_values


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
            and not same_departure(cause, before.get(cause.identity))
        )

    @property
    def false(self) -> tuple[Cause, ...]:
        """Leading causes among the new ones that are not what was planted."""
        return tuple(one for one in self.new if one.role == "leading" and not self._planted(one))

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


def same_departure(one: Cause, other: Cause | None) -> bool:
    """Whether two estimates depart as much from the nominal values: their intervals overlap."""
    if other is None:
        return False
    (low, high), (other_low, other_high) = (
        (cause.interval[0] - cause.nominal, cause.interval[1] - cause.nominal)
        for cause in (one, other)
    )
    return low <= other_high and other_low <= high


def set_scores(answers: Sequence[Answer]) -> dict[str, Any]:
    """Return the counts of one set's answers, and the coverage of intervals as a share.

    Questions with a distortion are counted apart: a correct verdict on one has no new leading
    cause.
    """
    planted = [one for one in answers if one.is_planted and not one.is_distortion]
    distorted = [one for one in answers if one.is_distortion]
    unplanted = [one.verdict for one in answers if not one.is_planted]
    covered = [inside for one in planted for inside in one.covered]
    return {
        "questions": len(planted),
        "leading": sum(one.leading for one in planted),
        "by_name": sum(one.by_name for one in planted),
        "exact": sum(one.exact for one in planted),
        "false_causes": sum(len(one.false) for one in planted),
        "intervals": len(covered),
        "covered": sum(covered),
        "coverage": rounded(sum(covered) / len(covered)) if covered else None,
        "distorted": len(distorted),
        "distorted_clean": sum(not one.false for one in distorted),
        "unplanted": len(unplanted),
        "unplanted_clean": sum(not verdict.leading for verdict in unplanted),
    }


def _quantity(identity: str) -> str:
    return Hypothesis.from_identity(identity).quantity
