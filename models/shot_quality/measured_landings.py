"""Measured: how a stroke landed, told by the cameras alone."""

import numpy as np
from numpy.typing import NDArray

from models.arena.sides import turned
from models.predictors.windows import Episode

Floats = NDArray[np.float64]

GRAVITY = 9.81  # m/s2; all else changes little in the few milliseconds between two samples
AT_NET = 4  # samples nearest to the net that tell the height over it
ROUNDING = 1e-6  # s


def seen_flying(episode: Episode) -> bool:
    """Return whether anything was seen of the ball between its stroke and its first contact."""
    return len(_first_arc(episode)) > 0


def struck_towards(episode: Episode) -> float:
    """Return 1 for a ball that is struck towards +y, -1 for one that is struck the other way."""
    first = _first_arc(episode)
    return float(np.sign(np.median(episode.velocities[first, 1])))


def landing(episode: Episode) -> tuple[Floats, float] | None:
    """Return the state just before the bounce, and the height at which the ball passed the net.

    Args:
        episode: of a stroke.

    Returns:
        (9,) in the frame of who struck, and m of the ball's centre; ``None`` where the ball did
        not touch the other half first, as in serves, or too little was seen of it.
    """
    first = _first_arc(episode)
    bounce = _bounce(episode)
    if bounce is None or len(first) < AT_NET:
        return None
    way = struck_towards(episode)
    states = turned(_states(episode, first)[None], np.array([way]))[0]
    landed = _moved(states[-1:], bounce - episode.times[first[-1:]])[0]
    landed[6:] = states[:, 6:].mean(axis=0)
    near = np.argsort(np.abs(states[:, 1]), kind="stable")[:AT_NET]
    at_net = _moved(states[near], -states[near, 1] / states[near, 4])
    known = np.isfinite(landed).all() and landed[1] > 0 and states[0, 1] < 0
    return (landed, float(at_net[:, 2].mean())) if known else None


def _first_arc(episode: Episode) -> NDArray[np.int64]:
    """Return the samples before the first contact that are no outliers."""
    flying = np.isfinite(episode.velocities).all(axis=1)
    return np.flatnonzero((episode.arc == 0) & flying & ~episode.outlier)


def _bounce(episode: Episode) -> float | None:
    """Return when the first contact was, if it was the table."""
    later = episode.times[episode.arc > 0]
    if not len(episode.bounces) or (len(later) and episode.bounces[0] > later[0] + ROUNDING):
        return None
    return float(episode.bounces[0])


def _states(episode: Episode, rows: NDArray[np.int64]) -> Floats:
    parts = (episode.positions, episode.velocities, episode.spins)
    return np.column_stack([part[rows] for part in parts])


def _moved(states: Floats, seconds: Floats) -> Floats:
    """Return (B, 9) states some seconds later, in free fall."""
    moved = states.copy()
    moved[:, :3] += states[:, 3:6] * seconds[:, None]
    moved[:, 2] -= GRAVITY / 2 * seconds**2
    moved[:, 5] -= GRAVITY * seconds
    return moved
