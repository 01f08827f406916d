"""Missing lift: whether shots curve by their spins although the simulator has no Magnus force.

Without spin labels such a simulator has no derivative by C_M: lift is a product of two parameters
that are both missing. Lift acts differently in every shot, which distinguishes it from a wrong
gravity. So each shot gets a free spin about a simulator with some C_M, the simulator's listed
parameters are free on both sides, and the squared errors, in the noise as estimated *with* lift,
must fall by more than three free parameters a shot explain (a likelihood-ratio test). Without
labels C_M itself is identified only by bounces; elsewhere it stays at its start.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised, linearise
from rallygap.models.gap.fit.noise import Noise, gram_matrices
from rallygap.models.gap.fit.projection import eliminate_nuisance
from rallygap.models.gap.fit.refit import RefitResult, refit
from rallygap.models.gap.fit.shared_errors import SharedErrors
from rallygap.models.gap.fit.shot_fit import refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.settings import GapSettings


@dataclass(frozen=True)
class LiftTest:
    """Test for a missing Magnus force.

    Attributes:
        with_lift: the shots about the simulator with Magnus force, its listed parameters refitted.
        p_value: of so large a fall of the squared errors without any lift.
    """

    with_lift: RefitResult
    p_value: float


def lift_test(shots: Shots, without: RefitResult, settings: GapSettings) -> LiftTest:
    """Test whether spins bend the paths of shots that were refitted without Magnus force."""
    simulator = without.simulator.amended("magnus", cm=settings.name.lift_start)
    free = (*without.free, Hypothesis("magnus", "cm"))
    with_lift = refit(shots, simulator, free, settings.fit)
    noise = with_lift.noise_estimate.noise
    corrected = with_lift.corrected_shots
    fit = refit_shots(corrected, without.simulator, without.linear.nuisance, noise, settings.fit)
    columns = hypotheses(without.simulator)
    linear = linearise(shots, without.simulator, fit.nuisance, columns)
    weights = np.minimum(fit.weights, with_lift.noise_estimate.weights)
    gain = _misfit(linear, noise, weights, settings)
    gain -= _misfit(with_lift.linear, noise, weights, settings)
    return LiftTest(with_lift, float(chi2.sf(gain, 3 * len(shots))))


def _misfit(linear: Linearised, noise: Noise, weights: Floats, settings: GapSettings) -> float:
    """Return the squared errors when nuisance parameters and listed parameters are fitted."""
    whole = np.ones(len(weights))
    grams = gram_matrices(linear, noise, weights, whole).total(noise)
    evidence = Evidence.of(linear, NoiseEstimate(noise, weights, whole, grams), settings)
    left = eliminate_nuisance(grams, linear.nuisance_count)
    shared = SharedErrors.of(left, len(linear.columns))
    free = [k for k in evidence.free if linear.columns[k].effect != "magnus"]
    return float(left.misfit.sum()) - shared.explained - evidence.score_test(free, []).gain
