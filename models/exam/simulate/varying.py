"""Causes that are not the same throughout a session: drifting, by shot, or in half of the room."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.simulator import Contacts, Flight
from rallygap.models.ball.types import Floats
from rallygap.models.exam.simulate.scattered_shots import BallModel
from rallygap.models.gap.hypotheses import Hypothesis

CHECKED = 0.002  # s between the moments at which a ball's side of the net is checked


@dataclass(frozen=True)
class Variation:
    """How the value of one hidden parameter varies.

    - ``drift``: linearly over the session, from nominal at the first shot; its mean is the value
      of the cause.
    - ``shot``: normally from shot to shot, around the value of the cause.
    - ``place``: the cause acts where y > 0, and nowhere else.
    """

    kind: Literal["drift", "shot", "place"]
    parameter: Hypothesis
    spread: float = 0.0  # of kind ``shot``: standard deviation, as a share of the value

    def values(
        self, nominal: float, value: float, shots: int, random: np.random.Generator
    ) -> Floats:
        """Return (shots,) values of the parameter, within its bounds."""
        if self.kind == "drift":
            values = nominal + (value - nominal) * np.linspace(0.0, 2.0, shots)
        else:
            values = value * (1.0 + self.spread * random.standard_normal(shots))
        return np.clip(values, *self.parameter.declaration.bounds)


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
