"""Verified causes: their verification on held-out shots."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import t as student

from rallygap.models.gap.fit.refit import RefitResult, fit_nuisance, likelihood_gains
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.causes import camera_size
from rallygap.models.gap.name.label_readings import read_labels, without_labels
from rallygap.models.gap.name.naming import Named, without_cause
from rallygap.models.gap.settings import GapSettings, Question
from rallygap.models.gap.verdict import Check, Gap
from rallygap.models.gap.verify.checks import NOT_OF_PATHS, checks
from rallygap.models.gap.verify.prediction_error import Errors, HeldOut, gap
from rallygap.models.gap.verify.roles import Judgement
from rallygap.models.gap.verify.worth import Worths


@dataclass(frozen=True)
class Verified:
    """Causes, with their verification on held-out shots.

    Attributes:
        named: the causes.
        measured: the held-out shots.
        question: that is asked.
        verification: these shots, fitted about the amended simulator.
        held: those that are long enough for predictions; None without any.
        errors: of predictions; None without any.
    """

    named: Named
    measured: Shots
    question: Question
    verification: RefitResult
    held: HeldOut | None
    errors: Errors | None

    @classmethod
    def of(cls, named: Named, shots: Shots, question: Question) -> "Verified":
        """Return the causes verified on held-out shots, as they were measured."""
        settings, noise = question.settings, named.fit.noise_estimate.noise
        verification = _fit_held_out(shots, named, settings)
        held = HeldOut.of(verification, shots, noise, settings)
        if not len(held.shots):
            return cls(named, shots, question, verification, None, None)
        seen = held.corrected if named.distortion else held.shots
        errors = held.errors((question.simulator, named.simulator), named.spins, seen)
        return cls(named, shots, question, verification, held, errors)

    @cached_property
    def gap(self) -> Gap | None:
        """Prediction errors; None where held-out shots are too short."""
        return gap(self.errors, self.question.settings) if self.errors else None

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether the model fits held-out shots, and its bounces those that are fitted."""
        return checks(self.named.fit, self.verification, self.errors, self.question.settings)

    @property
    def fits(self) -> bool:
        """Whether all checks pass."""
        return all(check.passed for check in self.checks)

    @property
    def paths_fit(self) -> bool:
        """Whether all checks pass, but of sizes that the model has: of labels and of bounces."""
        return all(check.passed or check.name in NOT_OF_PATHS for check in self.checks)

    @property
    def camera_size(self) -> tuple[float, float]:
        """Standard deviation of the position-dependent camera error, m, and its upper bound."""
        if self.named.distortion is None:
            return 0.0, np.inf
        size, (_, high) = camera_size(self.named, self.named.distortion)
        return size, high

    def is_likelier_than(self, other: "Verified") -> bool:
        """Whether held-out shots are significantly likelier, by the spread of their gains."""
        gains = likelihood_gains(other.verification, self.verification)
        error = np.sqrt(len(gains)) * gains.std(ddof=1)
        tail = (1 - self.question.settings.confidence) / 2
        return bool(gains.sum() > student.isf(tail, len(gains) - 1) * error)

    def without(self, k: int) -> "Verified":
        """Return the causes but one, refitted."""
        named = without_cause(self.named, k, self.question)
        return Verified.of(named, self.measured, self.question)

    def judgement(self, fits: bool, irreplaceable: frozenset[int] = frozenset()) -> Judgement:
        """Return what decides about the roles of the causes; none is known to be needed yet."""
        worths = Worths.of(self.named, self.verification, self.held, self.question)
        before = float(np.mean(self.gap.before_mm)) if self.gap else 0.0
        return Judgement(self.named, worths, fits, before, irreplaceable, frozenset())


def _fit_held_out(shots: Shots, named: Named, settings: GapSettings) -> RefitResult:
    """Return held-out shots fitted about the amended simulator, with corrected measurements."""
    simulator, noise = named.fit.simulator, named.fit.noise_estimate.noise
    if named.readings.useless:
        shots = without_labels(shots)
    shots = named.corrected(shots)
    about = fit_nuisance(shots, simulator, noise, settings.fit)
    if not named.readings.doubtful:
        return about
    readings = read_labels(shots, about, settings)
    # Two flipped labels are no cause, but where there is one, each of them is corrected.
    usable = readings.negated if named.readings.significant else readings.left_out
    return fit_nuisance(usable(shots), simulator, noise, settings.fit)
