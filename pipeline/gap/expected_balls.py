"""What shots say of the balls to come: the noise of the cameras, and the spins of the players."""

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.gap.fit.noise import NORMAL_SPREAD
from models.gap.fit.refit import refit
from models.gap.fit.shots import Shots
from models.gap.locate.covariates import course_frames
from models.gap.settings import DEFAULTS
from models.predictors.ball_filter import Expected

LEAST_SPREAD = 5.0  # rad/s


def expected_balls(shots: Shots, simulator: Simulator) -> Expected:
    """Return noise and spins of shots, as fitted about a simulator: medians and their spread."""
    fit = refit(shots, simulator, (), DEFAULTS.fit)
    along, right, up = np.moveaxis(course_frames(fit.linear), 1, 0)
    axes = np.stack([along, -right, up], axis=1)
    spins = np.einsum("bij,bj->bi", axes, fit.linear.nuisance[:, SPIN])
    typical = np.median(spins, axis=0)
    spread = NORMAL_SPREAD * np.median(np.abs(spins - typical), axis=0)
    return Expected(
        fit.noise_estimate.noise.position,
        tuple(typical.tolist()),
        tuple(np.maximum(spread, LEAST_SPREAD).tolist()),
    )
