"""Receivers: professionals who play against others of more or less reach, and of other errors."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.arena.event_log import Log
from models.arena.levels import LEVELS, Players
from models.arena.rallies import Rallies
from models.arena.truth import Truth
from models.policy.goals import Goals
from models.policy.outcome import judge
from models.shot_quality.shots import Shots, clearance, described, landings

Floats = NDArray[np.float64]

LEVEL = "pro"
NEAR = 0  # the side that strikes as ever, and whose shots count
ERRORS = ("angle_error", "speed_error", "spin_error")


@dataclass(frozen=True)
class Receiver:
    """Who has to return the shots: a professional with some traits changed.

    Attributes:
        name: for reports.
        reach: factor on how far they reach.
        error: factor on the errors of their strokes.
        draw: of points; those of one draw have the same strikers.
    """

    name: str
    reach: float = 1.0
    error: float = 1.0
    draw: int = 0


RECEIVERS = (
    Receiver("usual"),
    Receiver("usual_again", draw=1),
    Receiver("less_reach", reach=2 / 3),
    Receiver("more_reach", reach=4 / 3),
    Receiver("less_error", error=2 / 3),
    Receiver("more_error", error=4 / 3),
)


def played_against(
    receiver: Receiver, truth: Truth, points: int, random: np.random.Generator
) -> Shots:
    """Play points between professionals and a receiver, each a match of its own.

    Args:
        receiver: plays at y > 0.
        truth: the hall's physics.
        points: how many.
        random: where all variety comes from.

    Returns:
        The good returns of the professionals at y < 0; serves are none.
    """
    players = _changed(LEVELS[LEVEL].individuals(2 * points, random), receiver, points)
    log = Rallies(truth, players, random.integers(2, size=points), random).play()
    strokes, rallies = _near_strokes(log)
    outcome = judge(truth.simulator, strokes, Goals(np.zeros((len(strokes), 2))))
    good = outcome.returned
    last = np.append(rallies[1:] != rallies[:-1], True)
    point = log.winner[rallies] == NEAR
    features = described(
        landings(truth.simulator, strokes[good]), clearance(outcome.net_height[good])
    )
    return Shots(features, (point & last)[good], point[good], rallies[good])


def _changed(players: Players, receiver: Receiver, points: int) -> Players:
    """Return players (2 P,) of whom the far ones, the later half, are such receivers."""
    far = np.arange(2 * points) >= points
    error = np.where(far, receiver.error, 1.0)
    errors = {name: getattr(players, name) * error for name in ERRORS}
    return replace(players, reach=players.reach * np.where(far, receiver.reach, 1.0), **errors)


def _near_strokes(log: Log) -> tuple[Floats, NDArray[np.int64]]:
    """Return the (B, 9) states just after strokes towards +y and their (B,) points, in order."""
    points, times, kinds, states = (np.concatenate(part) for part in zip(*log.events, strict=True))
    near = np.flatnonzero((kinds == "racket") & (states[:, 4] > 0))
    order = near[np.lexsort([times[near], points[near]])]
    return states[order], points[order]
