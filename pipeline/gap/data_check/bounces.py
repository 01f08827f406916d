"""Bounces: contacts with a passive surface."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.contacts import Contact

SLOWEST = 0.5  # m/s towards and away from the surface
MOST_GAIN = 0.5  # m/s of speed, more is a racket
EDGE = 0.05  # m beyond the table, for errors of positions
ALONG, ACROSS = TABLE_HALF_LENGTH + EDGE, TABLE_HALF_WIDTH + EDGE


def bounce_places(contacts: Sequence[Contact], up: Floats) -> Floats:
    """Return (n, 3) places of contacts at which a passive surface throws the ball up.

    Args:
        contacts: of all recordings.
        up: (3,) unit vector.
    """
    places = [contact.position for contact in contacts if _is_bounce(contact, up)]
    return np.array(places).reshape(-1, 3)


def share_on_table(places: Floats) -> float:
    """Return the share of (n, 2) or (n, 3) places that are on the table."""
    inside = (np.abs(places[:, 0]) <= ACROSS) & (np.abs(places[:, 1]) <= ALONG)
    return float(inside.mean())


def _is_bounce(contact: Contact, up: Floats) -> bool:
    down, rise = -contact.before @ up, contact.after @ up
    gain = np.linalg.norm(contact.after) - np.linalg.norm(contact.before)
    return bool(down > SLOWEST and rise > SLOWEST and gain < MOST_GAIN)
