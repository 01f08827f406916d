"""Unknown: structure in what is left when the whole catalogue is free.

Every catalogued effect that the shots can show is free, so that none of them, nor several together,
can pass for an unknown one or hide it by standing in for it. Beside them the omnibus basis is
tested, as a whole and phase by phase. Null distributions come from the shots: their scores with
signs drawn at random. The lead is a sparse formula that pysindy's thresholded least squares find
for the same scores; it says what such an effect may look like, not that it is one.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.stats import chi2

from models.ball.types import Floats
from models.gap.basis import basis
from models.gap.components import Components, components
from models.gap.evidence import SIGN_FLIPS, Evidence
from models.gap.linear import Linearised
from models.gap.marginal import visible
from models.gap.noise import Noise
from models.gap.refit import Refitted

Phase = Literal["flight", "table", "sensor"]
PHASES: tuple[Phase, ...] = ("flight", "table", "sensor")
THRESHOLDS = np.geomspace(30.0, 3.0, 12)  # of the lead, in standard deviations
OWN_PART = 1e-4  # of a direction's information, that must be left beside the catalogue
RIDGE = 0.05  # terms that are nearly alike must not cancel
CONFIRMS = 2.5  # standard errors on other shots
ENOUGH = 0.8  # of what the whole basis explains


@dataclass(frozen=True)
class Leftover:
    """What is left beside the catalogue.

    Attributes:
        p_value: chance of so much structure without any.
        gain: of the basis in twice the log likelihood, beyond what as many directions of noise
            gain.
        shares: of the phases in it.
        test: the terms that say so.
    """

    p_value: float
    gain: float
    shares: dict[Phase, float]
    test: "_Test"

    @property
    def lead(self) -> str:
        """A sparse formula."""
        return _formula(self.test)

    def confirmed(self, others: Refitted, withheld: tuple[str, ...]) -> bool:
        """Whether other shots, about the same simulator, show the same structure."""
        joined = _joined(others.linear)
        known = Components.known(joined, self.test.noise, others.components.weights)
        theirs = _Test.of(Evidence.of(joined, known), withheld, self.test.noise)
        mine = dict(zip(self.test.places, self.test.estimate, strict=True))
        direction = np.array([mine.get(k, 0.0) for k in theirs.places])
        score = float(direction @ theirs.scores.sum(axis=0))
        error = float(np.sqrt(direction @ theirs.information @ direction))
        return bool(score > CONFIRMS * error)

    @property
    def where(self) -> Phase:
        """The phase that shows most of it."""
        return max(self.shares, key=lambda phase: self.shares[phase])


def leftover(found: Refitted, withheld: tuple[str, ...] = ()) -> Leftover:
    """Test whether structure is left beside the whole catalogue.

    Args:
        found: the shots about the simulator with the causes that were named.
        withheld: effects that are not in the catalogue.
    """
    joined = _joined(found.linear)
    noise = components(joined, found.components.noise, found.components.weights)
    evidence = Evidence.of(joined, noise)
    kinds: tuple[tuple[Phase, ...], ...] = (PHASES, *((phase,) for phase in PHASES))
    tests = [_Test.of(evidence, withheld, noise.noise, phases) for phases in kinds]
    generator = np.random.default_rng(0)
    signs = generator.choice([-1.0, 1.0], size=(SIGN_FLIPS, len(evidence.scores)))
    chances = [_chance(test, signs) for test in tests]
    leading = int(np.argmin(chances))
    gains = {phase: test.gain for phase, test in zip(PHASES, tests[1:], strict=True)}
    total = max(sum(gains.values()), 1e-12)
    shares = {phase: gain / total for phase, gain in gains.items()}
    p_value = min(1.0, len(tests) * chances[leading])
    return Leftover(p_value, tests[leading].gain, shares, tests[leading])


def _chance(test: "_Test", signs: Floats) -> float:
    """Return the chance of so much structure, by the spread between shots and by the noise.

    Shots whose values were fitted spread less than they did: the noise as found must agree.
    """
    along = test.along
    if along.shape[1] == 0:
        return 1.0
    squared = float((along.sum(axis=0) ** 2).sum())
    above = int((((signs @ along) ** 2).sum(axis=1) >= squared).sum())
    return max((1 + above) / (1 + len(signs)), float(chi2.sf(squared, along.shape[1])))


@dataclass(frozen=True)
class _Test:
    """The terms beside the catalogue.

    Attributes:
        evidence: for hypotheses and terms.
        noise: in which.
        beside: places of the catalogue.
        places: of the terms that the shots see.
        scores: (B, D) of the terms.
        information: (D, D).
        directions: (D, E) that are not in the span of the catalogue.
    """

    evidence: Evidence
    noise: Noise
    beside: list[int]
    places: list[int]
    scores: Floats
    information: Floats
    directions: Floats

    @classmethod
    def of(
        cls,
        evidence: Evidence,
        withheld: tuple[str, ...],
        noise: Noise,
        phases: Sequence[Phase] = PHASES,
    ) -> "_Test":
        seen = np.flatnonzero(evidence.seen).tolist()
        places = [k for k in seen if evidence.columns[k].effect in phases]
        apart = {*withheld, *PHASES}
        beside = [k for k in seen if evidence.columns[k].effect not in apart]
        scores, shares = _efficient(evidence, places, beside)
        information = shares.sum(axis=0)
        directions = _own_directions(evidence, places, information)
        return cls(evidence, noise, beside, places, scores, information, directions)

    @property
    def along(self) -> Floats:
        """(B, E) scores along the directions, of unit variance in sum."""
        along: Floats = self.scores @ self.directions
        return along

    @property
    def estimate(self) -> Floats:
        """(D,) of the terms."""
        estimate: Floats = self.directions @ self.along.sum(axis=0)
        return estimate

    @property
    def gain(self) -> float:
        """Of twice the log likelihood, beyond what as many directions of noise gain."""
        gain = float((self.along.sum(axis=0) ** 2).sum())
        return max(gain - float(self.along.shape[1]), 0.0)


def _joined(linear: Linearised) -> Linearised:
    """Return linearised shots with the terms among their columns."""
    terms = basis(linear)

    def put(columns: Floats, more: Floats) -> Floats:
        return np.concatenate([columns[..., :-1], more, columns[..., -1:]], axis=-1)

    return replace(
        linear,
        columns=(*linear.columns, *terms.terms),
        positions=put(linear.positions, terms.positions),
        labels=put(linear.labels, terms.labels),
    )


def _efficient(evidence: Evidence, places: list[int], beside: list[int]) -> tuple[Floats, Floats]:
    """Return (B, D) scores and (B, D, D) information beside hypotheses that may be alike."""
    a, total = evidence.information, evidence.total
    inverse = _inverse(total[np.ix_(beside, beside)])
    mixing = total[np.ix_(places, beside)] @ inverse
    free = inverse @ evidence.scores[:, beside].sum(axis=0)
    rest = evidence.scores - a[:, :, beside] @ free
    scores = rest[:, places] - rest[:, beside] @ mixing.T
    across = a[:, places][:, :, beside] - mixing @ a[:, beside][:, :, beside]
    shares = a[:, places][:, :, places] - mixing @ a[:, beside][:, :, places]
    return scores, shares - across @ mixing.T


def _inverse(information: Floats) -> Floats:
    directions = visible(information)
    inverse: Floats = directions @ directions.T
    return inverse


def _own_directions(evidence: Evidence, places: list[int], information: Floats) -> Floats:
    """Return (D, E) directions of which a good part is not in the span of the catalogue."""
    scale = np.sqrt(np.diag(evidence.total)[places])
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = values > OWN_PART
    directions: Floats = vectors[:, kept] / scale[:, None] / np.sqrt(values[kept])
    return directions


def _formula(test: _Test) -> str:
    """Return the sparsest formula of enough of the structure, by thresholded least squares."""
    own = np.diag(test.information)
    some = np.flatnonzero(own > OWN_PART * np.diag(test.evidence.total)[test.places])
    scale = np.sqrt(own[some])
    # Rows along which scores are white: least squares on them are the likelihood's.
    rows = test.directions.T @ test.information[:, some] / scale
    target = test.along.sum(axis=0)
    coefficients = _sparse(rows, target)
    chosen = np.flatnonzero(coefficients)
    names = [test.evidence.columns[test.places[some[k]]].parameter for k in chosen]
    values = (coefficients / scale)[chosen]
    return " ".join(f"{value:+.3g} [{one}]" for value, one in zip(values, names, strict=True))


def _sparse(rows: Floats, target: Floats) -> Floats:
    from pysindy.optimizers import STLSQ  # slow to import, and rarely needed

    coefficients: Floats = np.zeros(rows.shape[1])
    for threshold in THRESHOLDS:
        model = STLSQ(threshold=float(threshold), alpha=RIDGE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that nothing passes
            coefficients = np.ravel(model.fit(rows, target[:, None]).coef_)
        missed = target - rows @ coefficients
        if missed @ missed < (1 - ENOUGH) * (target @ target):
            break
    return coefficients
