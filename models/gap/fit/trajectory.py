"""Trajectories: balls from bounce to bounce, with a kick at each.

A kick ``(n, s, c)`` is the deviation of one bounce from the law, in units of the impact's normal
speed: the ball leaves faster by ``n`` upwards, ``s`` along the slip of its contact point and
``c`` across. The tangential part vanishes with the slip, where friction has nothing to scatter, and
comes with the spin that the conservation of angular momentum about the contact point requires,
``dw = -3/(2r) ez x dv``.
"""

from dataclasses import fields
from pathlib import Path

import numpy as np

from rallygap.models.ball.contact_laws import NET, TABLE
from rallygap.models.ball.simulator import Contacts, Flight, Simulator
from rallygap.models.ball.state import BALL_RADIUS, STATE_SIZE, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.gap.types import Bools, Indices
from rallygap.models.support.compilation import compiler

KICK_SIZE = 3
SLOW_SLIP = 1.0  # m/s below which the tangential part of a kick fades
EDGE = 5e-3  # m from an edge of the table: the ball may have touched it
# m, m/s, rad/s: bounds of states, for trial values that make drag a thrust.
FARTHEST = 1e5


def fly_with_kicks(
    simulator: Simulator, nuisance: Floats, times: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return (B, T, 9) states, from bounce to bounce where there are kicks.

    Then (B, M) contact times and (B,) those of the first contact with an edge or the net.
    """
    flight = _flight(simulator, nuisance[:, :STATE_SIZE], times)
    states, touched = flight.states, [_contacts(flight)]
    rows, start = np.arange(len(states)), np.zeros(len(states))
    for kick in range(STATE_SIZE, nuisance.shape[1], KICK_SIZE):
        there, time, before, after = first_bounce(flight)
        if not there.any():
            break
        rows, start = rows[there], start[there] + time
        launch = _bounded(apply_kicks(before, after, nuisance[rows, kick : kick + KICK_SIZE]))
        since = times[rows] - start[:, None]
        flight = _flight(simulator, launch, np.maximum(since, 0.0))
        _go_on(states, rows, since, flight.states)
        touched.append(np.full_like(touched[0], np.nan))
        touched[-1][:, rows] = start[:, None] + _contacts(flight)
    contacts, edges = np.concatenate(touched, axis=2)
    return states, contacts[:, np.isfinite(contacts).any(axis=0)], np.fmin.reduce(edges, axis=1)


def _contacts(flight: Flight) -> Floats:
    """Return (2, B, K) times of contacts, and of those with an edge or the net, else NaN."""
    contacts = flight.contacts
    x, y = np.abs(contacts.before[..., 0]), np.abs(contacts.before[..., 1])
    edge = (x > TABLE_HALF_WIDTH - EDGE) | (y > TABLE_HALF_LENGTH - EDGE)
    edge |= contacts.surface == NET
    return np.stack([contacts.time, np.where(edge, contacts.time, np.nan)])


def first_bounce(flight: Flight) -> tuple[Bools, Floats, Floats, Floats]:
    """Return which balls bounce off the table, and when, with which states, those that do."""
    table = flight.contacts.surface == TABLE
    there = table.any(axis=1)
    rows, first = np.flatnonzero(there), table.argmax(axis=1)[there]
    contacts = flight.contacts
    return (
        there,
        contacts.time[rows, first],
        contacts.before[rows, first],
        contacts.after[rows, first],
    )


def apply_kicks(before: Floats, after: Floats, kicks: Floats) -> Floats:
    """Return the (B, 9) states after bounces with (B, 3) kicks."""
    vx, vy, vz, wx, wy, _ = before[:, 3:].T
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx], axis=1)
    along = slip / np.sqrt((slip**2).sum(axis=1, keepdims=True) + SLOW_SLIP**2)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    size = np.abs(vz)[:, None]
    sideways = size * (kicks[:, 1:2] * along + kicks[:, 2:3] * across)
    states = after.copy()
    states[:, 3:5] += sideways
    states[:, 5:6] += size * kicks[:, :1]
    states[:, 6] += 1.5 / BALL_RADIUS * sideways[:, 1]
    states[:, 7] -= 1.5 / BALL_RADIUS * sideways[:, 0]
    return states


def _flight(simulator: Simulator, states: Floats, times: Floats) -> Flight:
    """Return the flight of balls; one that starts like the ball before it is not flown again.

    Kicks act from some bounce on: before it, the balls of their differences are the same.
    """
    new = np.ones(len(states), dtype=bool)
    new[1:] = (states[1:] != states[:-1]).any(axis=1)
    same = np.flatnonzero(~new)
    new[same] = (times[same] != times[same - 1]).any(axis=1)
    flight = simulator.fly(states[new], times[new])
    reached = _bounded(flight.states)
    if new.all():
        return Flight(reached, flight.contacts)
    place, contacts = np.cumsum(new) - 1, flight.contacts
    parts = (getattr(contacts, field.name)[place] for field in fields(contacts))
    return Flight(reached[place], Contacts(*parts))


def _bounded(states: Floats) -> Floats:
    """Return states within bounds far beyond those of real balls."""
    if states.min(initial=0.0) > -FARTHEST and states.max(initial=0.0) < FARTHEST:  # no NaN
        return states
    return np.clip(np.nan_to_num(states, posinf=FARTHEST, neginf=-FARTHEST), -FARTHEST, FARTHEST)


@compiler([Path(__file__)])
def _go_on(states: Floats, rows: Indices, since: Floats, later: Floats) -> None:
    """Replace rows of (B, T, 9) states by later ones, where the time since a bounce is positive."""
    for r in range(len(rows)):
        for i in range(since.shape[1]):
            if since[r, i] > 0.0:
                states[rows[r], i] = later[r, i]
