"""Simulated camera measurements of the ball at 200 Hz."""

import numpy as np

from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.incoming_balls import PATH_STEP
from rallygap.models.policy.settings import SensorNoise
from rallygap.models.predictors.protocol import TICK
from rallygap.models.predictors.windows import ROUNDING

_PATH_STEPS = round(TICK / PATH_STEP)  # between two measurements


def measure(
    path: Floats, until: Floats, noise: SensorNoise, random: np.random.Generator
) -> tuple[Floats, Bools]:
    """Measure balls of (B, N, 9) paths until (B,) s after their launches.

    Returns:
        (B, M, 6) positions (m) and spins (rad/s), the first at the launch, zero where not measured;
        and (B, M, 6) where they are.
    """
    true = path[:, ::_PATH_STEPS]
    shape = (*true.shape[:2], 3)
    size = np.linalg.norm(true[..., SPIN], axis=2, keepdims=True)
    positions = true[..., POSITION] + noise.position * random.standard_normal(shape)
    spins = true[..., SPIN] + noise.spin * size * random.standard_normal(shape)
    measured = TICK * np.arange(true.shape[1]) <= until[:, None] + ROUNDING
    mask = np.repeat(measured[..., None], 6, axis=2)
    return np.where(mask, np.concatenate([positions, spins], axis=2), 0.0), mask
