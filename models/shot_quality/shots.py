"""Shots: what a forest is told of a stroke that landed on the other half, and what came of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.contact_laws import TABLE
from models.ball.simulator import Simulator
from models.ball.state import BALL_RADIUS, NET_HEIGHT
from models.policy.outcome import LONGEST_FLIGHT, with_net

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

# In the frame of who strikes towards +y: place, velocity and spin just before the bounce, and how
# far above the net the ball passed. Its height at the bounce is always its radius.
FEATURES = ("across", "along", "vx", "vy", "vz", "wx", "wy", "wz", "clearance")


@dataclass(frozen=True)
class Shots:
    """B shots of players.

    Attributes:
        features: (B, 9) ``FEATURES``; m, m/s, rad/s.
        wins: (B,) whether the point was won with this very shot: the other did not return it.
        point: (B,) whether the point was won in the end, with this shot or a later one.
        matches: (B,) in which match.
    """

    features: Floats
    wins: Booleans
    point: Booleans
    matches: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.wins)


def described(landings: Floats, clearances: Floats) -> Floats:
    """Return the (B, 9) features of shots.

    Args:
        landings: (B, 9) states just before the bounce, struck towards +y.
        clearances: (B,) m.
    """
    return np.column_stack([landings[:, :2], landings[:, 3:], clearances])


def clearance(net_heights: Floats) -> Floats:
    """Return how far above the net (m) balls pass whose centres are (B,) m high there.

    It is negative for a ball that goes over the net cord.
    """
    return net_heights - NET_HEIGHT - BALL_RADIUS


def landings(simulator: Simulator, after: Floats) -> Floats:
    """Return the (B, 9) states in which balls come down on the table.

    Args:
        simulator: flies them; a net is set up where it has none.
        after: (B, 9) just after the racket, of balls that reach the table.
    """
    met = with_net(simulator).fly(after, [LONGEST_FLIGHT]).contacts
    first = (met.surface == TABLE).argmax(axis=1)
    states: Floats = met.before[np.arange(len(after)), first]
    return states
