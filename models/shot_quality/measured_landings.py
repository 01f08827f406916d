"""Landings of strokes, estimated from measured samples alone."""

import numpy as np

from rallygap.models.arena.sides import switch_frame
from rallygap.models.ball.types import Floats, Integers
from rallygap.models.predictors.windows import Episode

GRAVITY = 9.81  # m/s2; other accelerations are negligible over the milliseconds between samples
NET_SAMPLES = 4  # samples nearest to the net, from which the height over it is averaged
ROUNDING = 1e-6  # s


def has_first_arc(episode: Episode) -> bool:
    """Return whether the ball was measured between its stroke and its first contact."""
    return len(_first_arc(episode)) > 0


def stroke_direction(episode: Episode) -> float:
    """Return 1 for a ball that is struck towards +y, -1 towards -y."""
    first = _first_arc(episode)
    return float(np.sign(np.median(episode.velocities[first, 1])))


def landing(episode: Episode) -> tuple[Floats, float] | None:
    """Return the state just before the bounce, and the height at which the ball passed the net.

    Args:
        episode: of a stroke.

    Returns:
        (9,) in the frame of the striking player, and the height (m) of the ball's centre; ``None``
        where the ball did not touch the other half first, as in serves, or too few samples exist.
    """
    first = _first_arc(episode)
    later = episode.times[episode.arc > 0]
    if not len(episode.bounces) or len(first) < NET_SAMPLES:
        return None
    bounce = episode.bounces[0]
    if len(later) and bounce > later[0] + ROUNDING:  # the first contact was not the table
        return None
    parts = (episode.positions, episode.velocities, episode.spins)
    measured = np.column_stack([part[first] for part in parts])
    states = switch_frame(measured[None], np.array([stroke_direction(episode)]))[0]
    landed = _propagated(states[-1:], bounce - episode.times[first[-1:]])[0]
    landed[6:] = states[:, 6:].mean(axis=0)
    nearest = np.argsort(np.abs(states[:, 1]), kind="stable")[:NET_SAMPLES]
    at_net = _propagated(states[nearest], -states[nearest, 1] / states[nearest, 4])
    known = np.isfinite(landed).all() and landed[1] > 0 and states[0, 1] < 0
    return (landed, float(at_net[:, 2].mean())) if known else None


def _first_arc(episode: Episode) -> Integers:
    """Return the samples before the first contact that are no outliers."""
    flying = np.isfinite(episode.velocities).all(axis=1)
    return np.flatnonzero((episode.arc == 0) & flying & ~episode.outlier)


def _propagated(states: Floats, seconds: Floats) -> Floats:
    """Return (B, 9) states some seconds later, in free fall."""
    propagated = states.copy()
    propagated[:, :3] += states[:, 3:6] * seconds[:, None]
    propagated[:, 2] -= GRAVITY / 2 * seconds**2
    propagated[:, 5] -= GRAVITY * seconds
    return propagated
