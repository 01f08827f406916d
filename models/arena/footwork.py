"""Footwork: when and where a player meets the ball that comes.

All places are in the frame of the player who strikes, at y < 0 and playing towards +y.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arena.levels import Players
from models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

READY = np.array([0.0, -1.7])  # m: where players wait, that is where they would meet a ball
MOMENTS = np.arange(0.03, 0.8, 0.01)  # s after the bounce, at which a ball could be met
NEAREST_NET = 0.30  # m that a racket keeps to the net
LOWEST = -0.15  # m: no way back onto the table from further down
OVER_TABLE = 0.07  # m above the table that a racket needs
TIMING_WIDTH = 0.12  # by which a player departs from the preferred moment for ...
STRETCH_WIDTH = 0.60  # ... that much less stretch


@dataclass(frozen=True)
class Meeting:
    """Where players meet the ball.

    Attributes:
        reached: (B,) whether they get there in time.
        times: (B,) s after the bounce.
        balls: (B, 9) states at the contact.
        stretch: (B,) share of their range that it asks for, from 0 to 1.
    """

    reached: Booleans
    times: Floats
    balls: Floats
    stretch: Floats


def met(paths: Floats, warned: Floats, until: Floats, stands: Floats, players: Players) -> Meeting:
    """Choose the moment nearest to the preferred one that asks for no great stretch.

    Args:
        paths: (B, T, 9) states of the balls at ``MOMENTS`` after their bounce.
        warned: (B,) s from the opponent's stroke to the bounce.
        until: (B,) s after the bounce at which the ball is lost.
        stands: (B, 2) where the players are at the opponent's stroke.
        players: (B,) who have to get there.
    """
    apex = np.maximum(paths[:, 0, 5] / 9.81 + MOMENTS[0], 0.05)
    running = np.maximum(warned[:, None] + MOMENTS - players.reaction[:, None], 0)
    needed = np.linalg.norm(paths[..., :2] - stands[:, None], axis=-1)
    stretch = needed / (players.reach[:, None] + players.movement[:, None] * running)
    early = MOMENTS / apex[:, None] - players.timing[:, None]
    cost = (early / TIMING_WIDTH) ** 2 + (stretch / STRETCH_WIDTH) ** 2
    possible = _playable(paths) & (stretch <= 1) & (until[:, None] > MOMENTS)
    best = np.where(possible, cost, np.inf).argmin(axis=1)
    rows = np.arange(len(paths))
    return Meeting(possible.any(axis=1), MOMENTS[best], paths[rows, best], stretch[rows, best])


def returned(stands: Floats, seconds: Floats, players: Players) -> Floats:
    """Return where (B,) players stand some time after they stood elsewhere: on their way back."""
    way = READY - stands
    distance = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    share = np.minimum(players.movement * seconds / distance, 1)
    now: Floats = stands + share[:, None] * way
    return now


def _playable(paths: Floats) -> Booleans:
    x, y, z = np.moveaxis(paths[..., :3], -1, 0)
    over = (np.abs(x) < TABLE_HALF_WIDTH) & (y > -TABLE_HALF_LENGTH)
    playable: Booleans = (y < -NEAREST_NET) & (z > np.where(over, OVER_TABLE, LOWEST))
    return playable
