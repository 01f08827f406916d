"""The predictor protocol: from the last 12 measured ball states to the next 60."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rallygap.models.ball.types import Bools as Bools
from rallygap.models.ball.types import Floats as Floats

HISTORY = 12  # measured states in a predictor's input
FUTURE = 60  # forecast states
TICK = 0.005  # s between two of them

FUTURE_TIMES: Floats = TICK * np.arange(1.0, FUTURE + 1)  # s after the last measured state
HISTORY_TIMES: Floats = TICK * np.arange(1.0 - HISTORY, 1)  # s, the last measured state at zero


@dataclass(frozen=True)
class History:
    """The measured past of B balls, 5 ms apart.

    Attributes:
        states: (B, 12, 6) position (m) and spin (rad/s); zero where not measured.
        mask: (B, 12, 6) True where measured.

    Raises:
        ValueError: other shapes, numbers that are not finite, or values where nothing is measured.
    """

    states: Floats
    mask: Bools

    def __post_init__(self) -> None:
        shape = (len(self.states), HISTORY, 6)
        if self.states.shape != shape or self.mask.shape != shape:
            raise ValueError(f"a history is {shape}, not {self.states.shape}, {self.mask.shape}")
        if not np.isfinite(self.states).all() or self.states[~self.mask].any():
            raise ValueError("a history is finite, and zero where nothing was measured")

    @property
    def spin_measured(self) -> Bools:
        """(B,) whether the history has a spin label."""
        return np.any(self.mask[:, :, 3:].all(axis=2), axis=1)

    def __len__(self) -> int:
        return len(self.states)

    def __getitem__(self, rows: slice) -> "History":
        return History(self.states[rows], self.mask[rows])


def concatenate_histories(parts: Sequence[History]) -> History:
    """Return the histories of several batches as one."""
    return History(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.mask for part in parts]),
    )


@dataclass(frozen=True)
class Forecast:
    """The forecast of B balls.

    Attributes:
        states: (B, 60, 9) position (m), velocity (m/s), spin (rad/s), 5 to 300 ms ahead.
        spin_measured: (B,) whether the history had a spin label; without one the forecast spin
            is inferred from the path alone, or a prior.
    """

    states: Floats
    spin_measured: Bools


class Predictor(Protocol):
    """The whole interface of a predictor, as policies and the evaluation use it."""

    def predict(self, history: History) -> Forecast:
        """Forecast each ball of a batch, independently of the others in the batch."""
        ...


class ProbabilisticPredictor(Predictor, Protocol):
    """A predictor that says how far its forecasts may be off."""

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball, with covariances of its positions.

        Returns:
            The forecast, and (B, 60, 3, 3) covariances of its positions, m^2. They are not
            calibrated; calibration.py derives prediction regions of a given coverage from them.
        """
        ...
