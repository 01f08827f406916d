"""Shots: features of a stroke that landed on the other half, computed or measured; its outcome."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.sides import switch_frame
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.outcome import LONGEST_FLIGHT, with_net
from rallygap.models.predictors.windows import Episode

# In the frame of a player who strikes towards +y: position, velocity and spin just before the
# bounce, and the clearance over the net. The height at the bounce is always the ball's radius.
FEATURES = ("across", "along", "vx", "vy", "vz", "wx", "wy", "wz", "clearance")


GRAVITY = 9.81  # m/s2; other accelerations are negligible over the milliseconds between samples
NET_SAMPLES = 4  # samples nearest to the net, from which the height over it is averaged
ROUNDING = 1e-6  # s


@dataclass(frozen=True)
class Shots:
    """B shots of players.

    Attributes:
        features: (B, 9) ``FEATURES``; m, m/s, rad/s.
        wins: (B,) whether this shot won the point: the opponent did not return it.
        point: (B,) whether its player won the point, with this shot or a later one.
        matches: (B,) in which match.
    """

    features: Floats
    wins: Bools
    point: Bools
    matches: Integers

    def __len__(self) -> int:
        return len(self.wins)


def shot_features(landings: Floats, clearances: Floats) -> Floats:
    """Return the (B, 9) features of shots.

    Args:
        landings: (B, 9) states just before the bounce, struck towards +y.
        clearances: (B,) m.
    """
    return np.column_stack([landings[:, :2], landings[:, 3:], clearances])


def clearance(net_heights: Floats) -> Floats:
    """Return the clearance over the net (m) of balls whose centres pass it at (B,) heights (m).

    It is negative for a ball that rolls over the net cord.
    """
    return net_heights - NET_HEIGHT - BALL_RADIUS


def landings(simulator: Simulator, after: Floats) -> Floats:
    """Return the (B, 9) states just before the first bounce on the table.

    Args:
        simulator: computes the flight; a net is added where it has none.
        after: (B, 9) states just after the racket, of balls that reach the table.
    """
    contacts = with_net(simulator).fly(after, [LONGEST_FLIGHT]).contacts
    first = (contacts.surface == TABLE).argmax(axis=1)
    return contacts.before[np.arange(len(after)), first]


def has_first_arc(episode: Episode) -> bool:
    """Return whether the ball was measured between its stroke and its first contact."""
    return len(_first_arc(episode)) > 0


def stroke_direction(episode: Episode) -> float:
    """Return 1 for a ball that is struck towards +y, -1 towards -y."""
    first = _first_arc(episode)
    return float(np.sign(np.median(episode.velocities[first, 1])))


def measured_landing(episode: Episode) -> tuple[Floats, float] | None:
    """Return the state just before the bounce, and the height over the net, from samples alone.

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
    measured = np.hstack([episode.positions, episode.velocities, episode.spins])[first]
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
