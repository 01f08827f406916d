"""Roles of causes: which of them matter, and which are minor structure.

A main cause has a plausible value, not one at its bound, or is an effect of the simulator that the
shots do not have; its held-out gain of likelihood is significant; and predictions are not
significantly better without it. Where the model does not fit the shots, the likelihood is no judge:
predictions must be significantly worse without the cause, and not by a negligible amount only.
Minor causes are taken out one at a time, the least worthy first, and the others are refitted. A
cause is needed, and stays, if held-out shots that fit are then significantly less likely: the
likelihood gain above is linear, which is little use for lift saturation and the like. If the
position-dependent camera error ends larger than its interval with all causes, it has taken the
place of some: a smooth field bends paths as wind or gravity does, and held-out shots share it. Then
a cause is irreplaceable if that error grows so much when it is taken out; it stays if its gain of
likelihood is significant.
"""

from dataclasses import dataclass

from rallygap.models.gap.name.causes import default_role, estimated
from rallygap.models.gap.name.naming import Named
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import Worth
from rallygap.models.gap.verify.worth import Worths


@dataclass(frozen=True)
class Judgement:
    """What decides about the causes of a set.

    Attributes:
        named: the causes.
        worths: of them.
        fits: whether the model with all causes fits the shots.
        error_mm: of the nominal simulator's predictions; the scale of what is harmful.
        irreplaceable: places of causes that only a larger error of the cameras could replace.
        needed: places of causes without which held-out shots are significantly less likely.
    """

    named: Named
    worths: Worths
    fits: bool
    error_mm: float
    irreplaceable: frozenset[int]
    needed: frozenset[int]

    def identity(self, k: int) -> str:
        """Return the identity of a cause, by its place."""
        return self.named.explainer.evidence.columns[k].identity

    def weakest(self, question: Question) -> int | None:
        """Return the minor cause that is worth least, by its place; None without any."""
        minor = [k for k in self.named.explanation.causes if self._is_minor(k, question)]
        return min(minor, key=lambda k: self._mm(k), default=None)

    def _is_minor(self, k: int, question: Question) -> bool:
        hypothesis = self.named.explainer.evidence.columns[k]
        worth = self.worths.of_causes.get(hypothesis.identity)
        settings = question.settings.verify
        harmful = worth is not None and worth.interval[1] < -settings.worse * self.error_mm
        value, _ = estimated(self.named, k)
        if hypothesis.is_bound(value):
            return True
        if k in self.needed:
            return False
        if harmful:
            return True
        if k in self.irreplaceable and hypothesis.identity in self.worths.confirmed:
            return False
        if not self._is_needed(hypothesis.identity):
            return True
        negligible = worth is not None and worth.interval[1] < settings.min_worth * self._largest
        return negligible and not self.fits and default_role(hypothesis) == "leading"

    def _is_needed(self, identity: str) -> bool:
        worth = self.worths.of_causes.get(identity)
        needed = worth is None or worth.interval[0] > 0.0
        return identity in self.worths.confirmed and (self.fits or needed)

    @property
    def _largest(self) -> float:
        return max((worth.mm for worth in self.worths.of_causes.values()), default=0.0)

    def _mm(self, k: int) -> float:
        return self.worths.of_causes.get(self.identity(k), Worth(mm=0.0, interval=(0.0, 0.0))).mm
