"""Lift: whether balls curve by their spins, although the simulator has no Magnus force.

Such a simulator has no derivative by C_M where spins are unknown: lift is the product of two
numbers that are both missing. Where spins were measured it has, but is so far off that labels pass
for wrong ones and decoys for causes. What lift does is different in every shot, up, down or
aside, and that is what tells it from wrong gravity, which pulls all shots alike. So each shot gets
a spin of its own about a simulator with some C_M, the simulator's own values are free on both
sides, and the squared errors, in the noise as found *with* lift, must fall by more than three free
numbers a shot explain. Without labels C_M itself shows only where balls bounce; elsewhere it stays
what it was.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.linearize import Linearised, linearise
from models.gap.fit.marginal import marginal
from models.gap.fit.noise import Noise, grams
from models.gap.fit.refit import Refitted, refit
from models.gap.fit.shot_fit import refit_shots
from models.gap.fit.shots import Shots
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.inference.score_test import Evidence

LIFT = 0.1  # C_M; only its product with the spin shows in flight


@dataclass(frozen=True)
class Lift:
    """What spins explain.

    Attributes:
        with_lift: the shots about the simulator with Magnus force, its own values refitted.
        gain: fall of the squared errors, in units of the noise.
        p_value: of so large a gain without any lift.
    """

    with_lift: Refitted
    gain: float
    p_value: float


def lift(shots: Shots, without: Refitted) -> Lift:
    """Test whether spins bend the paths.

    Args:
        shots: with or without labels.
        without: the shots about a simulator without Magnus force, its own values refitted.
    """
    simulator: Simulator = without.simulator.amended("magnus", cm=LIFT)
    found = refit(shots, simulator, (*without.free, Hypothesis("magnus", "cm")))
    noise = found.components.noise
    fit = refit_shots(shots, without.simulator, without.linear.unknowns, noise)
    columns = hypotheses(without.simulator)
    about = linearise(shots, without.simulator, fit.unknowns, columns)
    weights = np.minimum(fit.weights, found.components.weights)
    gain = _misfit(about, noise, weights) - _misfit(found.linear, noise, weights)
    return Lift(found, gain, float(chi2.sf(gain, 3 * len(shots))))


def _misfit(linear: Linearised, noise: Noise, weights: Floats) -> float:
    """Return the squared errors left when unknowns and the simulator's own values are fitted."""
    left = marginal(grams(linear, noise, weights, np.ones(len(weights))).total(noise), linear.own)
    evidence = Evidence(linear.columns, linear.listed, left.scores, left.information)
    free = [one for one in evidence.free if linear.columns[one].effect != "magnus"]
    return float(left.misfit.sum()) - evidence.tested(free, []).gain
