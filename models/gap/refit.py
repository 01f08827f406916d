"""Refit: values of chosen hypotheses that make the shots most likely, exactly.

Gauss-Newton on the marginal likelihood: shots are fitted anew and linearised about the simulator as
it is now, the chosen values take the step that the scores ask for, and so on. The evidence for all
other hypotheses is then that about the refitted simulator.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.components import Components, components
from models.gap.evidence import Evidence
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.linear import Linearised, linearise
from models.gap.marginal import marginal, visible
from models.gap.noise import Noise, grams
from models.gap.shot_fit import ShotFit, fit_shots, refit_shots
from models.gap.shots import Shots

MOST_STEPS = 6
CLOSE = 0.2  # standard errors of a step after which no other is taken
FAR = 3.0  # standard errors of a step after which the noise is estimated anew


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

    @cached_property
    def evidence(self) -> Evidence:
        """For and against every hypothesis about the refitted simulator."""
        return Evidence.of(self.linear, self.components)


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
    fit = fit_shots(shots, simulator) if begin is None else _resumed(begin)
    known = begin is not None
    trust = np.ones(len(shots)) if begin is None else begin.components.trust
    for _ in range(MOST_STEPS if free else 0):
        linear = linearise(shots, simulator, fit.unknowns, free)
        if not known:
            found = components(linear, fit.noise, fit.weights)
            fit, trust = replace(fit, weights=found.weights, noise=found.noise), found.trust
        total = grams(linear, fit.noise, fit.weights, trust).total(fit.noise)
        step, error = _step(total, linear.own, free)
        simulator = _moved(simulator, free, step)
        fit = refit_shots(shots, simulator, fit.unknowns, fit.noise)
        if (np.abs(step) <= CLOSE * error).all():
            break
        known = bool((np.abs(step) < FAR * error).all())
    linear = linearise(shots, simulator, fit.unknowns, hypotheses(simulator))
    return Refitted(simulator, free, linear, components(linear, fit.noise, fit.weights))


def fitted(shots: Shots, simulator: Simulator, noise: Noise) -> Refitted:
    """Fit shots about a simulator whose values stay, in a noise that is known."""
    start = fit_shots(shots, simulator)
    fit = refit_shots(shots, simulator, start.unknowns, noise)
    linear = linearise(shots, simulator, fit.unknowns, hypotheses(simulator))
    return Refitted(simulator, (), linear, Components.known(linear, noise, fit.weights))


def _resumed(begin: Refitted) -> ShotFit:
    return ShotFit(begin.linear.unknowns, begin.components.weights, begin.components.noise)


def _step(total: Floats, own: int, free: tuple[Hypothesis, ...]) -> tuple[Floats, Floats]:
    """Return the step of the free values, and their standard errors.

    Values of which the shots say nothing within their range stay where they are.
    """
    left = marginal(total, own)
    information, score = left.information.sum(axis=0), left.scores.sum(axis=0)
    ranges = np.array([np.ptp(one.declaration.bounds) for one in free])
    told = np.ones(len(free), dtype=bool)
    for _ in free:
        directions = visible(information * np.outer(told, told))
        error = np.sqrt((directions**2).sum(axis=1))
        if (error < ranges).all():
            break
        told &= error < ranges
    step: Floats = directions @ (directions.T @ score)
    return step, error


def _moved(simulator: Simulator, free: tuple[Hypothesis, ...], step: Floats) -> Simulator:
    for hypothesis, change in zip(free, step, strict=True):
        value = hypothesis.value(simulator) + float(change)
        simulator = hypothesis.at(simulator, float(np.clip(value, *hypothesis.declaration.bounds)))
    return simulator
