"""Unexplained structure: what remains in the residuals when the whole catalogue is free.

Every catalogued effect that the shots can show is free, so that no effect, and no combination, can
pass for an unknown one or hide it. Given them, the omnibus terms (term_library.py) are tested in
two ways: all terms of a phase together, which detects whatever lies in their span, and each term
alone, which detects a smaller effect that resembles one of them. The null distribution of a phase
comes from the shots: their scores with random signs. What is found must be confirmed on other
shots. The candidate formula is a sparse fit to the same scores; it says what such an effect may
look like, not that it is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.ball.types import Floats
from models.gap.fit.noise import Noise
from models.gap.fit.refit import RefitResult
from models.gap.fit.variance_components import NoiseEstimate
from models.gap.inference.score_test import Evidence
from models.gap.locate.term_library import with_terms
from models.gap.name.phase_test import PhaseTest
from models.gap.name.sparse_formula import formula
from models.gap.settings import GapSettings
from models.gap.types import PHASES, Phase


@dataclass(frozen=True)
class UnexplainedStructure:
    """What is left beside the catalogue.

    Attributes:
        p_value: chance of so much structure without any.
        where: the phase that tells it best.
        shares: of the phases in what all of them gain.
        test: the terms of the phase that tells it best.
        terms: (D,) values of these terms that tell it best, others zero.
        noise: in which.
    """

    p_value: float
    where: Phase
    shares: dict[Phase, float]
    test: PhaseTest
    terms: Floats
    noise: Noise

    @property
    def gain(self) -> float:
        """Twice the gain of log likelihood beyond what as many directions of noise gain."""
        return self.test.gain

    @property
    def candidate_formula(self) -> str:
        """A sparse formula of terms of which a good part is not in the span of the catalogue."""
        test, some = self.test, list(self.test.alone)
        names = [test.evidence.columns[test.places[d]].parameter for d in some]
        rows = test.directions.T @ test.information[:, some]
        return formula(names, rows, test.along.sum(axis=0), test.evidence.settings.name)

    def confirmed(self, others: RefitResult) -> bool:
        """Whether other shots, about the same simulator, show the same structure."""
        score, error = self.test.predicted_score(
            self.terms, _evidence(others, self.noise, self.test.evidence.settings)
        )
        return score > self.test.evidence.settings.name.confirmation * error


def find_unexplained(
    fit: RefitResult, settings: GapSettings, withheld: Sequence[str] = ()
) -> UnexplainedStructure:
    """Test whether structure is left beside the whole catalogue.

    Args:
        fit: the shots about the simulator with the causes that were named.
        settings: of the workflow.
        withheld: effects that are not in the catalogue.
    """
    noise = fit.noise_estimate.noise
    evidence = _evidence(fit, noise, settings)
    tests = {phase: PhaseTest(evidence, phase, tuple(withheld)) for phase in PHASES}
    signs = np.random.default_rng(0).choice(
        [-1.0, 1.0], size=(settings.name.sign_flips, len(evidence.scores))
    )
    together = min(1.0, len(PHASES) * min(test.p_value(signs) for test in tests.values()))
    count = max(sum(len(test.alone) for test in tests.values()), 1)
    alone = min(1.0, count * min(test.p_value_alone for test in tests.values()))
    if alone < together:
        where = min(PHASES, key=lambda phase: tests[phase].p_value_alone)
        terms = tests[where].clearest
    else:
        where = min(PHASES, key=lambda phase: tests[phase].rarity)
        terms = tests[where].estimate
    total = max(sum(test.gain for test in tests.values()), 1e-12)
    shares = {phase: test.gain / total for phase, test in tests.items()}
    p_value = min(1.0, 2 * min(together, alone))
    return UnexplainedStructure(p_value, where, shares, tests[where], terms, noise)


def _evidence(fit: RefitResult, noise: Noise, settings: GapSettings) -> Evidence:
    """Return the evidence for hypotheses and terms."""
    linear = with_terms(fit.linear)
    known = NoiseEstimate.known(linear, noise, fit.noise_estimate.weights, settings.fit)
    return Evidence.of(linear, known, settings)
