"""Unexplained structure: what remains in the residuals when the whole catalogue is free.

Given the catalogue, omnibus terms (term_library.py) are tested in two ways: all terms of a phase
together, which detects whatever lies in their span, and each term alone, which detects a smaller
effect that resembles one of them. The null distribution of a phase comes from random signs of the
shots' scores. The candidate formula is a sparse fit to the same scores, not a cause.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.locate.term_library import evidence_with_terms
from rallygap.models.gap.name.phase_test import PhaseTest
from rallygap.models.gap.settings import NameSettings, Question
from rallygap.models.gap.types import PHASES, Phase


@dataclass(frozen=True)
class UnexplainedStructure:
    """What is left when the catalogue is free.

    Attributes:
        p_value: probability of so much structure without any.
        phase: that shows it best.
        test: the terms of this phase.
        terms: (D,) values of these terms that show it best, others zero.
        linear: the shots, with a column a term.
        noise: of the shots.
    """

    p_value: float
    phase: Phase
    test: PhaseTest
    terms: Floats
    linear: Linearised
    noise: Noise

    @property
    def candidate_formula(self) -> str:
        """A sparse formula of terms of which a good part is not in the span of the catalogue."""
        test, some = self.test, list(self.test.alone)
        names = [test.evidence.columns[test.places[d]].parameter for d in some]
        rows = test.directions.T @ test.information[:, some]
        return formula(names, rows, test.along.sum(axis=0), test.evidence.settings.name)

    def confirmed(self, others: RefitResult) -> bool:
        """Whether other shots, about the same simulator, show the same structure."""
        settings = self.test.evidence.settings
        _, evidence = evidence_with_terms(others, self.noise, settings)
        score, error = self.test.predicted_score(self.terms, evidence)
        return score > settings.critical_value * error


def find_unexplained(fit: RefitResult, question: Question) -> UnexplainedStructure:
    """Test whether the shots about the simulator with the causes show more than the catalogue."""
    noise, settings = fit.noise_estimate.noise, question.settings
    linear, evidence = evidence_with_terms(fit, noise, settings)
    tests = {phase: PhaseTest(evidence, phase, question.withheld) for phase in PHASES}
    signs = np.random.default_rng(0).choice(
        [-1.0, 1.0], size=(settings.name.sign_flips, len(evidence.scores))
    )
    together = min(1.0, len(PHASES) * min(test.p_value(signs) for test in tests.values()))
    count = max(sum(len(test.alone) for test in tests.values()), 1)
    alone = min(1.0, count * min(test.p_value_alone for test in tests.values()))
    if alone < together:
        phase = min(PHASES, key=lambda phase: tests[phase].p_value_alone)
        terms = tests[phase].clearest
    else:
        phase = min(PHASES, key=lambda phase: tests[phase].rarity)
        terms = tests[phase].estimate
    p_value = min(1.0, 2 * min(together, alone))
    return UnexplainedStructure(p_value, phase, tests[phase], terms, linear, noise)


def formula(names: Sequence[str], rows: Floats, target: Floats, settings: NameSettings) -> str:
    """Return the sparsest formula of D terms that explains enough of an (E,) target.

    Thresholded least squares (Brunton et al. 2016) on (E, D) white rows.
    """
    scale = np.linalg.norm(rows, axis=0)
    coefficients = _sparse(rows / scale, target, settings)
    chosen = np.flatnonzero(coefficients).tolist()
    values = (coefficients / scale)[chosen]
    return " ".join(f"{value:+.3g} [{names[k]}]" for k, value in zip(chosen, values, strict=True))


def _sparse(rows: Floats, target: Floats, settings: NameSettings) -> Floats:
    from pysindy.optimizers import STLSQ  # slow to import, and rarely needed

    coefficients: Floats = np.zeros(rows.shape[1])
    for threshold in settings.formula_thresholds:
        model = STLSQ(threshold=float(threshold), alpha=settings.formula_ridge)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that nothing passes
            coefficients = np.ravel(model.fit(rows, target[:, None]).coef_)
        missed = target - rows @ coefficients
        if missed @ missed < (1 - settings.formula_share) * (target @ target):
            break
    return coefficients
