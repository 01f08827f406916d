"""Goals of returns: landing place, and optionally speed and topspin."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.types import Floats
from rallygap.models.policy.settings import GoalSettings

Rows = slice | NDArray[np.bool_] | NDArray[np.integer]

# Scales of goals in observations, the same in every experiment.
LANDING_CENTRE, LANDING_SCALE = np.array([0.0, 0.8]), np.array([0.45, 0.3])  # m
SPEED_CENTRE, SPEED_SCALE = 5.5, 1.5  # m/s
TOPSPIN_SCALE = 100.0  # rad/s


@dataclass(frozen=True)
class Goals:
    """The goals of B returns.

    Attributes:
        landing: (B, 2) where the return first touches the table, x and y (m).
        speed: (B,) of the ball just after the racket (m/s); None where there is no such goal.
        topspin: (B,) of the ball just after the racket (rad/s), about the horizontal axis across
            its flight, negative is backspin; None where there is no such goal.
    """

    landing: Floats
    speed: Floats | None = None
    topspin: Floats | None = None

    def scaled(self) -> Floats:
        """Return (B, G) values of about [-1, 1]: landing x and y, and speed and topspin if set."""
        parts = [(self.landing - LANDING_CENTRE) / LANDING_SCALE]
        if self.speed is not None:
            parts.append(((self.speed - SPEED_CENTRE) / SPEED_SCALE)[:, None])
        if self.topspin is not None:
            parts.append((self.topspin / TOPSPIN_SCALE)[:, None])
        return np.hstack(parts)

    def distance(self, landing: Floats) -> Floats:
        """Return the distances (B,) m of (B, 2) landing places from the goals."""
        return np.linalg.norm(landing - self.landing, axis=1)

    def __len__(self) -> int:
        return len(self.landing)

    def __getitem__(self, rows: Rows) -> "Goals":
        """Return the goals of some of the returns."""
        return Goals(
            self.landing[rows],
            None if self.speed is None else self.speed[rows],
            None if self.topspin is None else self.topspin[rows],
        )


def draw_goals(settings: GoalSettings, count: int, random: np.random.Generator) -> Goals:
    """Draw goals uniformly, each quantity independently."""

    def drawn(limits: tuple[float, float] | None) -> Floats | None:
        return None if limits is None else random.uniform(*limits, size=count)

    landing = [
        random.uniform(*limits, size=count)
        for limits in (settings.landing_across, settings.landing_along)
    ]
    return Goals(np.stack(landing, axis=1), drawn(settings.speed), drawn(settings.topspin))
