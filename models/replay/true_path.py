"""The true path of an arena ball until the next stroke."""

import numpy as np

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.types import Floats
from rallygap.models.policy.incoming_balls import PATH_TIMES

STROKES = ("launch", "racket")


def true_path(truth: Truth, contacts: TrueContacts, start: float) -> tuple[Floats, Floats]:
    """Return the true path of a ball from ``start`` (s) to the next stroke or the end of the data.

    Args:
        truth: the arena's physics.
        contacts: of the recording; the ball's own stroke is the one nearest to ``start``.
        start: s, on the recording's clock.

    Returns:
        (n, 9) states at ``start`` plus the first n of ``PATH_TIMES``, and (C,) s from ``start`` of
        the bounces in that time.
    """
    strokes = contacts.times[np.isin(contacts.kinds, STROKES)]
    nearest = np.abs(strokes - start).argmin()
    struck = np.append(strokes, np.inf)[nearest + 1]
    times = np.asarray(start + PATH_TIMES, dtype=np.float64)
    states = true_states(truth, contacts, times)
    known = np.isfinite(states[:, 0]) & (times < struck)
    count = int(np.argmin(np.append(known, False)))
    bounces = contacts.times[contacts.kinds == "table"] - start
    return states[:count], bounces[(bounces > 0) & (bounces < PATH_TIMES[:count].max(initial=0))]
