"""A session: balls that have been played, each bounce with the deviation that it had."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from models.arena.bounce_scatter import BounceScatter
from models.ball.contact_laws import NONE, TABLE
from models.ball.simulator import Contacts, Flight, Simulator
from models.ball.state import STATE_SIZE

Floats = NDArray[np.float64]

FOLLOWED = 4  # bounces that scatter; further ones follow the law


class Ball(Protocol):
    """Whatever flies balls by a law: a simulator, or the independent ball."""

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Roll out (B, 9) states to (T,) or (B, T) times."""
        ...


@dataclass(frozen=True)
class Session(Simulator):
    """A simulator of the very balls that were played: flown again, they bounce as they did.

    So the sensor can look at them at any time, as it looks at a simulator's balls.

    Attributes:
        ball: flies between the bounces.
        launches: (B, 9) states at time zero.
        contacts: what the balls met, scatter included.
    """

    ball: Ball
    launches: Floats
    contacts: Contacts

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Return the played balls at (B, T) or (T,) times.

        Raises:
            ValueError: ``states`` are not the launches of this session.
        """
        if not np.array_equal(states, self.launches):
            raise ValueError("a session flies its own launches")
        moments = np.atleast_2d(np.asarray(times, dtype=np.float64))
        moments = np.broadcast_to(moments, (len(self.launches), moments.shape[1]))
        paths = self.ball.fly(self.launches, moments).states.copy()
        for k in range(self.contacts.count.max(initial=0)):
            since = self.contacts.time[:, k]
            on = np.flatnonzero(moments[:, -1] >= since)
            elapsed = moments[on] - since[on, None]
            later = self.ball.fly(self.contacts.after[on, k], np.maximum(elapsed, 0.0)).states
            paths[on] = np.where(elapsed[..., None] >= 0.0, later, paths[on])
        return Flight(paths, self.contacts)


def played(
    ball: Ball,
    simulator: Simulator,
    launches: Floats,
    durations: Floats,
    scatter: BounceScatter,
    random: np.random.Generator,
) -> Session:
    """Play balls: fly to the bounce, deviate, fly on.

    Args:
        ball: by whose law they fly and bounce.
        simulator: where the table is, and what the sensor makes of the balls.
        launches: (B, 9) states at time zero.
        durations: (B,) s for which the balls are followed.
        scatter: how far bounces deviate.
        random: where the deviations come from, the same number for every ball.
    """
    shape = (len(launches), FOLLOWED)
    times, surfaces = np.full(shape, np.nan), np.full(shape, NONE)
    before, after = np.full((2, *shape, STATE_SIZE), np.nan)
    now, current = np.zeros(len(launches)), launches
    going = np.arange(len(launches))
    for k in range(FOLLOWED):
        left = np.maximum(durations[going] - now[going], 0.0)
        met = ball.fly(current, np.stack([np.zeros_like(left), left], axis=1)).contacts
        on = met.count > 0
        if not on.any():
            break
        going = going[on]
        now[going] += met.time[on, 0]
        before[going, k], after[going, k] = met.before[on, 0], met.after[on, 0]
        times[going, k], surfaces[going, k] = now[going], met.surface[on, 0]
        table = going[surfaces[going, k] == TABLE]
        deviated = scatter.deviated(simulator, before[table, k], after[table, k], random)
        after[table, k] = deviated
        current = after[going, k]
    count = (surfaces != NONE).sum(axis=1)
    contacts = Contacts(count, times, surfaces, before, after)
    return Session(simulator.effects, ball, launches, contacts)
