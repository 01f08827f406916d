"""The true path of a ball, simulated from its true contacts."""

import numpy as np

from rallygap.models.arena.contacts import fly_to_contact
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats, Integers

ARCS_PER_BATCH = 256  # arcs flown at once; arcs of similar length share their padding
ROUNDING = 1e-9  # s


def true_states(truth: Truth, contacts: TrueContacts, times: Floats) -> Floats:
    """Return the (n, 9) true states at (n,) rising times, s.

    They are NaN before the first contact, and between the time when the ball leaves the view or has
    a contact that is not listed, and the next listed contact.
    """
    moments = np.asarray(times, dtype=np.float64)
    states = np.full((len(moments), STATE_SIZE), np.nan)
    arcs = np.searchsorted(contacts.times, moments, side="right") - 1
    elapsed = moments - contacts.times[arcs]
    ends = fly_to_contact(truth, contacts.states)
    known = elapsed <= np.minimum(ends.times, ends.lost)[arcs] + ROUNDING
    playing = (arcs >= 0) & known
    states[playing] = along_arcs(truth.simulator, contacts.states, arcs[playing], elapsed[playing])
    return states


def along_arcs(simulator: Simulator, starts: Floats, arcs: Integers, elapsed: Floats) -> Floats:
    """Return (n, 9) states along many arcs.

    Args:
        simulator: of the flight.
        starts: (A, 9) states at the arcs' starts.
        arcs: (n,) the arc of each moment, not falling.
        elapsed: (n,) s since the arc's start, not falling within an arc.
    """
    used, first, counts = np.unique(arcs, return_index=True, return_counts=True)
    states = np.empty((len(arcs), STATE_SIZE))
    by_length = np.argsort(counts, kind="stable")
    for start in range(0, len(used), ARCS_PER_BATCH):
        some = by_length[start : start + ARCS_PER_BATCH]
        steps = np.arange(counts[some].max())
        rows = first[some, None] + np.minimum(steps, counts[some, None] - 1)
        states[rows] = simulator.fly(starts[used[some]], elapsed[rows]).states
    return states
