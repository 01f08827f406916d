"""Unknown: structure in what is left when the whole catalogue is free.

Every catalogued effect that the shots can show is free, so that none of them, nor several together,
can pass for an unknown one or hide it by standing in for it. Beside them the omnibus basis is
tested in two ways: all terms of a phase together, which sees whatever lies in their span, and each
term alone, which sees what is much like one of them at a smaller size. Null distributions of a
phase come from the shots: their scores with signs drawn at random. What is found must hold on other
shots, too. The lead is a sparse formula that pysindy's thresholded least squares find for the same
scores; it says what such an effect may look like, not that it is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.ball.types import Floats
from models.gap.fit.noise import Noise
from models.gap.fit.refit import Refitted
from models.gap.fit.variance_components import Components
from models.gap.inference.score_test import Evidence
from models.gap.locate.term_library import joined
from models.gap.name.phase_test import PhaseTest
from models.gap.name.sparse_formula import formula
from models.gap.types import PHASES, Phase

SIGN_FLIPS = 20_000
CONFIRMS = 2.5  # standard errors on other shots


@dataclass(frozen=True)
class Leftover:
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
    def lead(self) -> str:
        """A sparse formula of terms of which a good part is not in the span of the catalogue."""
        test, some = self.test, list(self.test.alone)
        names = [test.evidence.columns[test.places[d]].parameter for d in some]
        rows = test.directions.T @ test.information[:, some]
        return formula(names, rows, test.along.sum(axis=0))

    def confirmed(self, others: Refitted) -> bool:
        """Whether other shots, about the same simulator, show the same structure."""
        score, error = self.test.foretold(self.terms, _evidence(others, self.noise))
        return score > CONFIRMS * error


def leftover(found: Refitted, withheld: Sequence[str] = ()) -> Leftover:
    """Test whether structure is left beside the whole catalogue.

    Args:
        found: the shots about the simulator with the causes that were named.
        withheld: effects that are not in the catalogue.
    """
    noise = found.components.noise
    evidence = _evidence(found, noise)
    tests = {phase: PhaseTest(evidence, phase, tuple(withheld)) for phase in PHASES}
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(SIGN_FLIPS, len(evidence.scores)))
    together = min(1.0, len(PHASES) * min(test.chance(signs) for test in tests.values()))
    count = max(sum(len(test.alone) for test in tests.values()), 1)
    alone = min(1.0, count * min(test.chance_alone for test in tests.values()))
    if alone < together:
        where = min(PHASES, key=lambda phase: tests[phase].chance_alone)
        terms = tests[where].clearest
    else:
        where = min(PHASES, key=lambda phase: tests[phase].rarity)
        terms = tests[where].estimate
    total = max(sum(test.gain for test in tests.values()), 1e-12)
    shares = {phase: test.gain / total for phase, test in tests.items()}
    p_value = min(1.0, 2 * min(together, alone))
    return Leftover(p_value, where, shares, tests[where], terms, noise)


def _evidence(found: Refitted, noise: Noise) -> Evidence:
    """Return the evidence for hypotheses and terms."""
    linear = joined(found.linear)
    return Evidence.of(linear, Components.known(linear, noise, found.components.weights))
