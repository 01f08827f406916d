"""Shots: the features of a stroke that landed on the other half, and its outcome."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.outcome import LONGEST_FLIGHT, with_net

# In the frame of a player who strikes towards +y: position, velocity and spin just before the
# bounce, and the clearance over the net. The height at the bounce is always the ball's radius.
FEATURES = ("across", "along", "vx", "vy", "vz", "wx", "wy", "wz", "clearance")


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
