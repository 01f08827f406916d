"""Variance components: noise, label errors and scatter, by restricted likelihood.

The noise is what no hypothesis explains. Were the noise estimated about the simulator as it is, a
missing effect would pass for a slow camera error or for scatter, and hide itself. So the values of
all hypotheses are integrated out (labels, scatter), or those directions of them that stand out are
fitted first (positions, of which there are plenty).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import Bounds, minimize

from models.ball.state import SPIN, STATE_SIZE
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised
from models.gap.fit.marginal import coefficients, marginal, visible
from models.gap.fit.noise import Grams, Noise, grams, inlier_probability, white_gram
from models.gap.fit.shots import evenly
from models.gap.types import Bools, Indices

STANDS_OUT = 2.5  # standard errors
MOST_SHOTS = 40  # of which the positions' noise is estimated ...
MOST_BOUNCING = 70  # ... and label errors and scatter
MOST_ROUNDS = 2
SETTLED = 0.03  # relative change of the positions' noise after which there is no other round
DOUBTFUL = (5.0, 15.0)  # standard deviations: from where a shot is trusted less, and not at all
NORMAL_SPREAD = 1.4826  # standard deviation over median deviation of a normal
LEAST_TRUST = 1e-4
LEAST_MISFIT = 1e-6  # a degree of freedom, where shots fit exactly
MOST_SPIN = 1500.0  # rad/s
MOST_KICK = 0.5  # of the normal speed
# What is plausible: m, m, s, s; shares of the spin; shares of the normal speed.
LIMITS = {
    "white": (1e-5, 0.1),
    "slow": (1e-5, 0.1),
    "slow_time": (0.01, 0.5),
    "timing": (1e-6, 5e-3),
    "label": (1e-3, 1.0),
    "label_common": (1e-3, 1.0),
    "scatter": (1e-3, 0.5),
}
# Where a search begins at the least: near zero, logarithms of sizes change nothing.
BEGIN = {"slow": 3e-4, "timing": 1e-4, "label_common": 5e-3, "scatter": 3e-3}


@dataclass(frozen=True)
class Components:
    """Noise of B shots, and what follows from it.

    Attributes:
        noise: its sizes.
        weights: (B, N) probabilities that samples are no outliers.
        trust: (B,) in whole shots, 1 for all but those that fit far worse than most.
        grams: (B, C, C) Gram matrices of the linearised shots in the metric of the noise.
    """

    noise: Noise
    weights: Floats
    trust: Floats
    grams: Floats

    def __getitem__(self, rows: Indices) -> "Components":
        """Return what is known of some of the shots."""
        return Components(self.noise, self.weights[rows], self.trust[rows], self.grams[rows])

    @classmethod
    def known(cls, linear: Linearised, noise: Noise, weights: Floats) -> "Components":
        """Return what follows from a noise that is known; which shots to trust among it."""
        parts = grams(linear, noise, weights, np.ones(len(weights)))
        trust = _trust(linear, parts.total(noise))
        return cls(noise, weights, trust, replace(parts, trust=trust).total(noise))


def components(linear: Linearised, noise: Noise, weights: Floats) -> Components:
    """Estimate the noise of linearised shots, from a first guess of it and of outliers."""
    trust = np.ones(len(weights))
    for _ in range(MOST_ROUNDS):
        before = noise.position
        parts = grams(linear, noise, weights, trust)
        noise, weights = _inliers(linear, _unexplained(linear, parts.total(noise), noise), noise)
        noise = _of_positions(linear, parts, noise, weights)
        parts = grams(linear, noise, weights, np.ones(len(weights)))
        trust = _trust(linear, parts.total(noise))
        some = evenly(len(weights), MOST_BOUNCING)
        noise = _of_the_rest(replace(parts, trust=trust)[some], noise)
        if abs(noise.position - before) < SETTLED * before:
            break
    return Components(noise, weights, trust, replace(parts, trust=trust).total(noise))


def _unexplained(linear: Linearised, total: Floats, noise: Noise) -> Floats:
    """Return (B, N, 3) residuals, steadied, after the unknowns and what stands out of the rest."""
    value = _standing_out(total, linear.own)
    inner = coefficients(total, linear.own, value)
    changes = np.concatenate([inner, np.broadcast_to(value, (len(inner), len(value)))], axis=1)
    rest = linear.positions[..., -1] - np.einsum(
        "bnic,bc->bni", linear.positions[..., :-1], changes
    )
    return noise.steadied(rest[..., None], linear.velocities)[..., 0]


def _inliers(linear: Linearised, rest: Floats, noise: Noise) -> tuple[Noise, Floats]:
    """Return (B, N) probabilities that samples are no outliers, and the noise they are judged in.

    It is at least as large as the typical residual: were it not, all samples might be outliers.
    """
    if linear.sampled.any():
        typical = NORMAL_SPREAD * float(np.median(np.abs(rest[linear.sampled])))
        noise = noise.widened(max(typical / noise.position, 1.0))
    return noise, np.where(linear.sampled, inlier_probability(rest, noise), 0.0)


def _standing_out(total: Floats, own: int) -> Floats:
    """Return (K,) values of the hypotheses along the directions that stand out."""
    left = marginal(total, own)
    directions = visible(left.information.sum(axis=0))
    scores = directions.T @ left.scores.sum(axis=0)
    values: Floats = directions @ np.where(np.abs(scores) > STANDS_OUT, scores, 0.0)
    return values


def _of_positions(linear: Linearised, parts: Grams, noise: Noise, weights: Floats) -> Noise:
    """Return noise with the positions' part that makes some of the shots most likely."""
    some = evenly(len(weights), MOST_SHOTS)
    value = _standing_out(parts.total(noise), linear.own)
    shots = _few(linear, some, value)
    trust = parts.trust[some, None, None]
    rest = parts.total(noise)[some] - trust * parts.positions[some]
    own = linear.own
    beyond = np.concatenate([np.zeros(own), -value, [1.0]])
    kept = np.concatenate([np.eye(own, len(beyond)), beyond[None]])
    rest = kept @ rest @ kept.T

    def criterion(trial: Noise) -> float:
        products, determinants = white_gram(shots.positions, shots, trial, weights[some])
        left = marginal(trust * products + rest, own)
        # Shots that are not trusted must not count in the determinants either.
        weighted = parts.trust[some] * (determinants + left.determinants)
        return float((weighted + left.misfit).sum())

    return _most_likely(criterion, noise, ("white", "slow", "slow_time", "timing"))


def _few(linear: Linearised, some: Indices, value: Floats) -> Linearised:
    """Return some shots with their unknowns' columns and what the hypotheses leave, alone."""
    few, own = linear[some], linear.own
    residual = few.positions[..., -1] - few.positions[..., own:-1] @ value
    columns = np.concatenate([few.positions[..., :own], residual[..., None]], axis=-1)
    return replace(few, columns=(), positions=columns)


def _of_the_rest(parts: Grams, noise: Noise) -> Noise:
    """Return noise with the label errors and scatter that make the shots most likely."""
    own = parts.unknowns.shape[1]
    first = marginal(parts.total(noise), own).information.sum(axis=0)
    directions = visible(first)

    def criterion(trial: Noise) -> float:
        left = marginal(parts.total(trial), own)
        information = directions.T @ left.information.sum(axis=0) @ directions
        score = directions.T @ left.scores.sum(axis=0)
        explained = score @ np.linalg.solve(information, score)
        precision = parts.precision(trial)
        priors = -np.log(np.where(precision > 0.0, precision, 1.0)).sum(axis=1)
        determinants = left.determinants + priors + parts.label_determinants(trial)
        total = parts.trust @ determinants + np.linalg.slogdet(information)[1]
        return float(total + left.misfit.sum() - explained)

    names = [] if (parts.counts == 0).all() else ["label"]
    names += ["label_common"] if (parts.counts > 1).any() else []
    names += ["scatter"] if own > STATE_SIZE else []
    return _most_likely(criterion, noise, tuple(names)) if names else noise


def _most_likely(
    criterion: Callable[[Noise], float], noise: Noise, names: tuple[str, ...]
) -> Noise:
    """Return noise with the named sizes at which ``criterion`` is least, within ``LIMITS``."""
    sizes = [np.atleast_1d(np.maximum(getattr(noise, one), BEGIN.get(one, 0.0))) for one in names]
    ends = np.cumsum([len(size) for size in sizes])
    limits = np.log([LIMITS[name] for name, size in zip(names, sizes, strict=True) for _ in size])

    def changed(logarithms: Floats) -> Noise:
        parts = np.split(np.exp(logarithms), ends[:-1])
        values: dict[str, Any] = {
            name: tuple(part.tolist()) if name == "scatter" else float(part[0])
            for name, part in zip(names, parts, strict=True)
        }
        return replace(noise, **values)

    first = np.clip(np.log(np.concatenate(sizes)), limits[:, 0], limits[:, 1])
    found: Any = minimize(  # type: ignore[call-overload]
        lambda logarithms: criterion(changed(logarithms)),
        first.tolist(),
        method="L-BFGS-B",
        bounds=Bounds(*limits.T),
        options={"maxiter": 25.0, "ftol": 1e-7, "eps": 1e-3},
    )
    return changed(found.x)


def _trust(linear: Linearised, total: Floats) -> Floats:
    """Return (B,) weights of shots: those that fit far worse than most count less.

    First as they fit the simulator as it is, then beside what the others say of it.
    """
    left = marginal(total, linear.own)
    rows = 3 * (linear.sampled.sum(axis=1) + linear.labelled.sum(axis=1)) - STATE_SIZE
    rows = np.maximum(rows, 1)
    trust = _relative(left.misfit, rows)
    value = _standing_out(total * trust[:, None, None], linear.own)
    misfit = left.misfit - 2 * left.scores @ value
    misfit += np.einsum("i,bij,j->b", value, left.information, value)
    return np.where(_plausible(linear), _relative(misfit, rows), LEAST_TRUST)


def _plausible(linear: Linearised) -> Bools:
    """Return (B,) which fits are of this world; the others ended in a wrong minimum."""
    spin = np.linalg.norm(linear.unknowns[:, SPIN], axis=1)
    kick = np.abs(linear.unknowns[:, STATE_SIZE:]).max(axis=1, initial=0.0)
    plausible: Bools = (spin < MOST_SPIN) & (kick < MOST_KICK)
    return plausible


def _relative(misfit: Floats, rows: Floats) -> Floats:
    """Return weights by how many standard deviations a shot's misfit is beyond the typical one."""
    typical = max(float(np.median(misfit / rows)), LEAST_MISFIT)
    ratio = misfit / rows / typical
    spread = np.maximum(NORMAL_SPREAD * np.median(np.abs(ratio - 1.0)), np.sqrt(2.0 / rows))
    low, high = DOUBTFUL
    trust: Floats = np.clip((high - (ratio - 1.0) / spread) / (high - low), LEAST_TRUST, 1.0)
    return trust
