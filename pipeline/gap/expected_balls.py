"""What shots say of the balls to come: the noise of the cameras, and the spins of the players."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
from pydantic import BaseModel, FiniteFloat, PositiveFloat

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import SPIN
from rallygap.models.gap.fit.noise import NORMAL_SPREAD
from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.locate.covariates import course_frames
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.io.artifacts import read_as

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


class _Content(BaseModel, extra="forbid"):
    noise: PositiveFloat
    spin: tuple[FiniteFloat, FiniteFloat, FiniteFloat]
    spin_spread: tuple[PositiveFloat, PositiveFloat, PositiveFloat]


def expected_json(expected: Expected) -> str:
    """Return the content of a file of expected balls, with five digits."""
    rounded = np.vectorize(lambda value: float(f"{value:.5g}"))
    content = {name: rounded(value).tolist() for name, value in asdict(expected).items()}
    return json.dumps(content) + "\n"


def read_expected(path: Path) -> Expected:
    """Read a file of expected balls.

    Raises:
        InputError: it is missing, or a value in it is invalid.
    """
    content = read_as(path, _Content, advice="give the balls.json of a verdict")
    return Expected(**content.model_dump())
