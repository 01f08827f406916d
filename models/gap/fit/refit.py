"""Refit: values of chosen hypotheses that make the shots most likely, exactly.

Gauss-Newton on the marginal likelihood: shots are linearised about the simulator as it is now, the
chosen values take the step that the scores ask for, the unknowns of the shots the one that goes
with it, and so on. A step after which the shots fit worse was too long and is shortened. Values
stay within their bounds; a weak prior keeps those of which the shots say nothing where they are.
The evidence for all other hypotheses is then that about the refitted simulator.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised, linearise
from models.gap.fit.marginal import coefficients, marginal
from models.gap.fit.noise import Grams, Noise, grams
from models.gap.fit.shot_fit import ShotFit, fit_shots, refit_shots
from models.gap.fit.shots import Shots
from models.gap.fit.variance_components import Components, components
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.types import Indices

MOST_STEPS = 6  # from scratch ...
FEW_STEPS = 3  # ... and from a simulator nearby: the next linearisation takes one more
CLOSE = 0.2  # standard errors of a step after which no other is taken
FAR = 3.0  # standard errors of a step from scratch after which the noise is estimated anew
PRIOR = 1 / 6  # of a value's range: its standard deviation before the shots are seen
SHORTER = (1.0, 0.25, 0.05)  # parts of a step that are tried
WORSE = 1.01  # times the cost up to which a step is taken: shots alone know no slow errors
FOLLOWING = 3  # iterations of shots whose unknowns went along


@dataclass(frozen=True)
class Refitted:
    """Shots fitted about a simulator whose chosen values were refitted.

    Attributes:
        simulator: with the values found.
        free: the hypotheses whose values were refitted.
        linear: the shots about it, for all hypotheses.
        components: their noise.
    """

    simulator: Simulator
    free: tuple[Hypothesis, ...]
    linear: Linearised
    components: Components

    def __getitem__(self, rows: Indices) -> "Refitted":
        """Return some of the shots, about the same simulator in the same noise."""
        return replace(self, linear=self.linear[rows], components=self.components[rows])


def refit(
    shots: Shots,
    simulator: Simulator,
    free: tuple[Hypothesis, ...],
    begin: Refitted | None = None,
) -> Refitted:
    """Refit the values of ``free``.

    Args:
        shots: of which at least one bounces if a free value is of the table.
        simulator: where the values start; a missing effect is appended.
        free: what is refitted.
        begin: the same shots about a simulator nearby, to start from.
    """
    for hypothesis in free:
        simulator = hypothesis.at(simulator, hypothesis.value(simulator))
    start = values = _values(simulator, free)
    fit = fit_shots(shots, simulator) if begin is None else _resumed(begin, simulator)
    steps = MOST_STEPS if begin is None else FEW_STEPS
    known = begin is not None
    trust = np.ones(len(shots)) if begin is None else begin.components.trust
    for _ in range(steps if free else 0):
        linear = linearise(shots, simulator, fit.unknowns, free)
        if not known:
            found = components(linear, fit.noise, fit.weights)
            fit, trust = replace(fit, weights=found.weights, noise=found.noise), found.trust
        parts = grams(linear, fit.noise, fit.weights, trust)
        step, error = _step(parts.total(fit.noise), linear.own, free, values, start)
        moved = _moved(linear, parts, fit, step)
        if moved is None:
            break
        simulator, fit = moved
        values = _values(simulator, free)
        if (np.abs(step) <= CLOSE * error).all():
            break
        known = begin is not None or bool((np.abs(step) < FAR * error).all())
    linear = linearise(shots, simulator, fit.unknowns, hypotheses(simulator))
    return Refitted(simulator, free, linear, components(linear, fit.noise, fit.weights))


def fitted(shots: Shots, simulator: Simulator, noise: Noise) -> Refitted:
    """Fit shots about a simulator whose values stay, in a noise that is known."""
    start = fit_shots(shots, simulator)
    fit = refit_shots(shots, simulator, start.unknowns, noise)
    linear = linearise(shots, simulator, fit.unknowns, hypotheses(simulator))
    return Refitted(simulator, (), linear, Components.known(linear, noise, fit.weights))


def gained(one: Refitted, other: Refitted) -> float:
    """Return by how much less the same shots miss the ``other`` simulator, with fitted unknowns.

    It is twice the gain of log likelihood in the noise about the other, of samples, labels and
    shots that both trust. Labels err by a share of the spins as fitted, and positions by what time
    stamps miss at the velocities as fitted: both are weighed by those about the other. Each by its
    own, smaller spins and velocities would pass for a worse fit.
    """
    noise = other.components.noise
    about = replace(other.linear, labelled=one.linear.labelled & other.linear.labelled)
    weights = np.minimum(one.components.weights, other.components.weights)
    trust = np.minimum(one.components.trust, other.components.trust)
    before, after = (_misfit(found.linear, about, noise, weights, trust) for found in (one, other))
    return before - after


def _misfit(
    linear: Linearised, about: Linearised, noise: Noise, weights: Floats, trust: Floats
) -> float:
    kept = [*range(linear.own), -1]  # the unknowns, and what is left
    units = np.where(about.labelled, linear.units / about.units, 0.0)
    alone = replace(
        linear,
        columns=(),
        positions=linear.positions[..., kept],
        velocities=about.velocities,
        labels=linear.labels[..., kept] * units[..., None, None],
        labelled=about.labelled,
    )
    left = marginal(grams(alone, noise, weights, trust).total(noise), linear.own)
    return float(left.misfit.sum())


def _values(simulator: Simulator, free: tuple[Hypothesis, ...]) -> Floats:
    return np.array([one.value(simulator) for one in free])


def _with_values(simulator: Simulator, free: tuple[Hypothesis, ...], values: Floats) -> Simulator:
    for hypothesis, value in zip(free, values, strict=True):
        simulator = hypothesis.at(simulator, float(value))
    return simulator


def _resumed(begin: Refitted, simulator: Simulator) -> ShotFit:
    """Return shots fitted about a simulator near that of an earlier refit."""
    linear, known = begin.linear, begin.components
    change = _values(simulator, linear.columns) - _values(begin.simulator, linear.columns)
    unknowns = linear.unknowns + coefficients(known.grams, linear.own, change)
    return refit_shots(linear.shots, simulator, unknowns, known.noise, FOLLOWING)


def _step(
    total: Floats, own: int, free: tuple[Hypothesis, ...], values: Floats, start: Floats
) -> tuple[Floats, Floats]:
    """Return the best step of the free values within their bounds, and their standard errors."""
    left = marginal(total, own)
    bounds = np.array([one.declaration.bounds for one in free])
    scale = PRIOR * np.ptp(bounds, axis=1)
    # In units of the prior's standard deviations, whose precision is one.
    information = left.information.sum(axis=0) * np.outer(scale, scale) + np.eye(len(free))
    score = left.scores.sum(axis=0) * scale - (values - start) / scale
    root = np.linalg.cholesky(information)
    low, high = ((bounds - values[:, None]) / scale[:, None]).T
    found = lsq_linear(root.T, np.linalg.solve(root, score), (low, high))
    return scale * found.x, scale * np.sqrt(np.diag(np.linalg.inv(information)))


def _moved(
    linear: Linearised, parts: Grams, fit: ShotFit, step: Floats
) -> tuple[Simulator, ShotFit] | None:
    """Return the simulator after as much of a step as fits no worse, and the shots about it."""
    shots, free, noise = linear.shots, linear.columns, fit.noise
    values, total = _values(linear.simulator, free), parts.total(noise)
    here = refit_shots(shots, linear.simulator, fit.unknowns, noise, 0)
    for part in SHORTER:
        simulator = _with_values(linear.simulator, free, values + part * step)
        unknowns = fit.unknowns + coefficients(total, linear.own, part * step)
        there = _followed(shots, simulator, unknowns, here)
        if parts.trust @ there.cost <= WORSE * (parts.trust @ here.cost):
            return simulator, there
    return None


def _followed(shots: Shots, simulator: Simulator, unknowns: Floats, here: ShotFit) -> ShotFit:
    """Return shots about a simulator nearby; those that the way there loses start where they were.

    One lost shot, whose samples pass for outliers, could outweigh what all others gain.
    """
    there = refit_shots(shots, simulator, unknowns, here.noise, FOLLOWING)
    lost = np.flatnonzero(there.cost > WORSE * here.cost)
    if not len(lost):
        return there
    again = refit_shots(shots[lost], simulator, here.unknowns[lost], here.noise, FOLLOWING)
    return there.with_better(lost, again)
