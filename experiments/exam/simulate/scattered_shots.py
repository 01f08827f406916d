"""Shots whose bounces scatter, each by a deviation that is kept, and rooms with two dynamics."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.ball.contact_laws import NONE, TABLE
from rallygap.models.ball.simulator import Contacts, Flight, Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats

CHECKED = 0.002  # s between the moments at which a ball's side of the net is checked
MOST_SCATTERED = 4  # bounces of a shot that scatter; further ones follow the law


class BallModel(Protocol):
    """What rolls out balls: a simulator, or the independent ball."""

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Roll out (B, 9) states to (T,) or (B, T) times."""
        ...


@dataclass(frozen=True)
class ScatteredShots(Simulator):
    """A simulator that replays shots with the bounces that they had.

    The sensor model observes it at any times, as it observes every simulator.
    """

    ball: BallModel  # moves balls between the bounces
    launches: Floats  # (B, 9) states at time zero
    contacts: Contacts  # with the table, scatter included

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Return the shots at (B, T) or (T,) times.

        Raises:
            ValueError: ``states`` are not the launches of these shots.
        """
        if not np.array_equal(states, self.launches):
            raise ValueError("scattered shots can only be replayed from their own launches")
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


def scattered_shots(
    ball: BallModel,
    simulator: Simulator,
    launches: Floats,
    durations: Floats,
    scatter: BounceScatter,
    random: np.random.Generator,
) -> ScatteredShots:
    """Roll out shots from bounce to bounce, and let each bounce deviate.

    Args:
        ball: moves and bounces the balls.
        simulator: with the place of the table, and the sensor effects.
        launches: (B, 9) states at time zero.
        durations: (B,) s to simulate.
        scatter: of the bounces.
        random: of the deviations; every ball takes the same number of draws.
    """
    shape = (len(launches), MOST_SCATTERED)
    times, surfaces = np.full(shape, np.nan), np.full(shape, NONE)
    before, after = np.full((2, *shape, STATE_SIZE), np.nan)
    now, current = np.zeros(len(launches)), launches
    going = np.arange(len(launches))
    for k in range(MOST_SCATTERED):
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
        after[table, k] = scatter.apply(simulator, before[table, k], after[table, k], random)
        current = after[going, k]
    count = (surfaces != NONE).sum(axis=1)
    contacts = Contacts(count, times, surfaces, before, after)
    return ScatteredShots(simulator.effects, ball, launches, contacts)


@dataclass(frozen=True)
class HalfRoom:
    """A ball that follows one model where y > 0, and another one elsewhere."""

    inside: BallModel  # where y > 0
    outside: BallModel

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Roll out balls; arguments are those of ``Simulator.fly``.

        Only the first contact is returned, and a ball changes the model once: shots are rolled out
        from bounce to bounce, and cross the plane of the net once at most in between.
        """
        first = np.atleast_2d(np.asarray(states, dtype=np.float64))
        moments = np.atleast_2d(np.asarray(times, dtype=np.float64))
        moments = np.broadcast_to(moments, (len(first), moments.shape[1]))
        flights = [self._fly_one(*ball) for ball in zip(first, moments, strict=True)]
        contacts = [flight.contacts for flight in flights]
        count = np.concatenate([np.minimum(met.count, 1) for met in contacts])
        columns = {
            name: np.concatenate([getattr(met, name)[:, :1] for met in contacts])
            for name in ("time", "surface", "before", "after")
        }
        states = np.concatenate([flight.states for flight in flights])
        return Flight(states, Contacts(count, **columns))

    def _fly_one(self, state: Floats, moments: Floats) -> Flight:
        """Roll out one ball from its (9,) state to (T,) moments."""
        models = (self.inside, self.outside) if state[1] > 0.0 else (self.outside, self.inside)
        here, there = models
        before = here.fly(state[None], moments)
        crossing = _crossing(here, state, moments[-1])
        if crossing is None:
            return before
        until = here.fly(state[None], np.array([0.0, crossing]))
        after = there.fly(until.states[:, 1], np.maximum(moments - crossing, 0.0))
        states = np.where((moments > crossing)[:, None], after.states, before.states)
        if until.contacts.count[0] > 0:
            return Flight(states, until.contacts)
        return Flight(states, replace(after.contacts, time=after.contacts.time + crossing))


def _crossing(ball: BallModel, state: Floats, until: float) -> float | None:
    """Return when a ball crosses the plane of the net, s, None where it does not."""
    times = np.linspace(0.0, max(until, 0.0), max(int(until / CHECKED), 0) + 2)
    y = ball.fly(state[None], times).states[0, :, 1]
    (other,) = np.nonzero((y > 0.0) != (state[1] > 0.0))
    if not len(other):
        return None
    k = other[0]
    return float(times[k - 1] - y[k - 1] * (times[k] - times[k - 1]) / (y[k] - y[k - 1]))
