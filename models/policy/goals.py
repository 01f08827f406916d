"""Goals: what a return is asked to do."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.policy.settings import GoalSettings

Floats = NDArray[np.float64]
Rows = slice | NDArray[np.bool_] | NDArray[np.integer]

# What goals are measured in, fixed so that a policy reads them alike in every experiment.
LANDING_CENTRE, LANDING_SCALE = np.array([0.0, 0.8]), np.array([0.45, 0.3])  # m
SPEED_CENTRE, SPEED_SCALE = 5.5, 1.5  # m/s
TOPSPIN_SCALE = 100.0  # rad/s


@dataclass(frozen=True)
class Goals:
    """The goals of B returns.

    Attributes:
        landing: (B, 2) where the return first touches the table, x and y (m).
        speed: (B,) of the ball just after the racket (m/s); None where it is not asked for.
        topspin: (B,) of the ball just after the racket (rad/s), about the axis across its way,
            negative is backspin; None where it is not asked for.
    """

    landing: Floats
    speed: Floats | None = None
    topspin: Floats | None = None

    def scaled(self) -> Floats:
        """Return (B, G) numbers of about [-1, 1]: landing x and y, speed and topspin if asked."""
        parts = [(self.landing - LANDING_CENTRE) / LANDING_SCALE]
        if self.speed is not None:
            parts.append(((self.speed - SPEED_CENTRE) / SPEED_SCALE)[:, None])
        if self.topspin is not None:
            parts.append((self.topspin / TOPSPIN_SCALE)[:, None])
        return np.hstack(parts)

    def distance(self, landing: Floats) -> Floats:
        """Return how far (m) the (B, 2) places of landing are from those asked for."""
        apart: Floats = np.linalg.norm(landing - self.landing, axis=1)
        return apart

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
    """Draw goals evenly, each quantity independently of the others."""

    def drawn(limits: tuple[float, float] | None) -> Floats | None:
        return None if limits is None else random.uniform(*limits, size=count)

    landing = [
        random.uniform(*limits, size=count)
        for limits in (settings.landing_across, settings.landing_along)
    ]
    return Goals(np.stack(landing, axis=1), drawn(settings.speed), drawn(settings.topspin))
