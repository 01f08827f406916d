"""Motion of the players: when and where a player intercepts the incoming ball.

All positions are in the frame of the player who strikes, at y < 0 and playing towards +y.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.levels import Players
from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Bools, Floats

READY = np.array([0.0, -1.7])  # m, ready position
CONTACT_TIMES = np.arange(0.03, 0.8, 0.01)  # s after the bounce, possible racket contacts
NEAREST_NET = 0.30  # m, smallest distance of a racket from the net
LOWEST = -0.15  # m, lowest contact
OVER_TABLE = 0.07  # m, lowest contact above the table
# Weights of the cost: deviation from the preferred time (share of the time to the apex), stretch.
TIMING_WIDTH = 0.12
STRETCH_WIDTH = 0.60


@dataclass(frozen=True)
class Interception:
    """Where B players intercept the ball."""

    reached: Bools  # (B,) whether the player gets there in time
    times: Floats  # (B,) s after the bounce
    balls: Floats  # (B, 9) states at the contact
    stretch: Floats  # (B,) needed share of the player's range, from 0 to 1


def intercept(
    paths: Floats, lead_time: Floats, until: Floats, stands: Floats, players: Players
) -> Interception:
    """Choose the racket contact: near the preferred time and without much stretch.

    Args:
        paths: (B, T, 9) states of the balls at ``CONTACT_TIMES`` after their bounce.
        lead_time: (B,) s from the opponent's stroke to the bounce.
        until: (B,) s after the bounce at which the ball is lost.
        stands: (B, 2) positions of the players at the opponent's stroke, m.
        players: (B,) receiving players.
    """
    apex = np.maximum(paths[:, 0, 5] / 9.81 + CONTACT_TIMES[0], 0.05)
    running = np.maximum(lead_time[:, None] + CONTACT_TIMES - players.reaction[:, None], 0)
    needed = np.linalg.norm(paths[..., :2] - stands[:, None], axis=-1)
    stretch = needed / (players.reach[:, None] + players.movement[:, None] * running)
    early = CONTACT_TIMES / apex[:, None] - players.timing[:, None]
    cost = (early / TIMING_WIDTH) ** 2 + (stretch / STRETCH_WIDTH) ** 2
    x, y, z = np.moveaxis(paths[..., :3], -1, 0)
    over = (np.abs(x) < TABLE_HALF_WIDTH) & (y > -TABLE_HALF_LENGTH)
    playable = (y < -NEAREST_NET) & (z > np.where(over, OVER_TABLE, LOWEST))
    possible = playable & (stretch <= 1) & (until[:, None] > CONTACT_TIMES)
    best = np.where(possible, cost, np.inf).argmin(axis=1)
    rows = np.arange(len(paths))
    return Interception(
        possible.any(axis=1), CONTACT_TIMES[best], paths[rows, best], stretch[rows, best]
    )


def recover(stands: Floats, seconds: Floats, players: Players) -> Floats:
    """Return (B, 2) positions of players who walk back to ``READY`` for some seconds."""
    way = READY - stands
    distance = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    share = np.minimum(players.movement * seconds / distance, 1)
    return stands + share[:, None] * way
