"""Worth of a cause: how much held-out shots are predicted worse when it alone is taken out.

Predictions are compared shot by shot. Whether a cause is needed also follows from the likelihood of
all shots, each fold judged by the estimate of the others.
"""

from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.inference.score_test import Evidence, ScoreTest
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.name.naming import Named, with_estimates
from rallygap.models.gap.name.selection import evidence_about
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import Worth
from rallygap.models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from rallygap.models.gap.verify.prediction_error import HeldOut


@dataclass(frozen=True)
class Worths:
    """What the causes are worth.

    Attributes:
        of_causes: by identity, in prediction errors; empty where held-out shots are too few.
        confirmed: identities of causes with a significant held-out gain of likelihood.
    """

    of_causes: dict[str, Worth]
    confirmed: frozenset[str]

    @classmethod
    def of(
        cls, named: Named, verification: RefitResult, held: HeldOut | None, question: Question
    ) -> "Worths":
        """Return the worths of all causes, the position-dependent camera error included."""
        evidence, places = named.explainer.evidence, named.explanation.causes
        identities = {k: evidence.columns[k].identity for k in places}
        tests = _tests(named, verification, question)
        confirmed = frozenset(identities[k] for k in places if tests[k].gains_significantly)
        in_predictions = {} if held is None else _in_predictions(named, held, identities)
        return cls(in_predictions, confirmed)


def _tests(named: Named, verification: RefitResult, question: Question) -> dict[int, ScoreTest]:
    """Return the tests of all causes, each given the others, by all shots."""
    known = named.explainer.evidence
    further = evidence_about(replace(verification, free=named.fit.free), question)
    count = len(known.scores) - known.of_prior

    def joined(first: Floats, second: Floats) -> Floats:
        return np.concatenate([first[:count], second, first[count:]])

    whole = Evidence(
        known.columns,
        known.listed,
        joined(known.scores, further.scores),
        joined(known.information, further.information),
        known.settings,
        known.of_prior,
    )
    places = named.explanation.causes
    return {k: whole.score_test([k], [j for j in places if j != k]) for k in places}


def _in_predictions(named: Named, held: HeldOut, identities: dict[int, str]) -> dict[str, Worth]:
    seen = held.corrected if named.distortion else held.shots
    spin = named.spins[1]
    whole = held.squares(named.simulator, spin, seen)
    reached = np.isfinite(whole).sum(axis=0) >= held.settings.verify.min_shots
    if not reached.any():
        return {}
    places = named.explanation.causes
    without = {
        identity: held.squares(
            with_estimates(named.explainer, tuple(j for j in places if j != k)), spin, seen
        )
        for k, identity in identities.items()
    }
    if named.distortion is not None:
        without[CAMERA.identity] = held.squares(named.simulator, spin, held.shots)
    return {
        identity: _worth(np.stack([whole, squares])[..., reached], held)
        for identity, squares in without.items()
    }


def _worth(squares: Floats, held: HeldOut) -> Worth:
    """Return the worth by (2, B, H) squares of errors with a cause and without it."""
    settings = held.settings
    drawn = resampled(squares, settings.verify.bootstrap_draws)
    growth = 1e3 * (drawn[:, 1] - drawn[:, 0]).mean(axis=1)
    sizes = root_mean_squares(squares)
    mm = round(1e3 * float((sizes[1] - sizes[0]).mean()), 6)
    return Worth(mm=mm, interval=interval(growth, settings.confidence))
