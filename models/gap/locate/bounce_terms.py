"""Bounce terms: kicks that depend on the impact and its place, and a shifted surface."""

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, POSITION, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised
from rallygap.models.gap.fit.trajectory import KICK_SIZE
from rallygap.models.gap.locate.propagation import Arc, after_jump
from rallygap.models.gap.locate.terms import TYPICAL_FALL, Flown, Term, Terms
from rallygap.models.gap.types import Bools, Indices

KICKS = ("n", "s", "c")
FACTORS = (
    "",
    "v_n",
    "slip",
    "spin",
    "/v_n",
    "v_x/v_n",
    "v_y/v_n",
    "/(1 + slip/v_n)",
    "at x",
    "at y",
)
# Jumps of the state, whatever the slip: kicks in the frame's directions, and a shifted surface.
JUMPS = ("v_x", "v_y", "height", "height at x", "height at y")
SLOWEST_FALL = 0.3  # m/s
GRAVITY = 9.81  # m/s^2


def of_bounces(flown: Flown) -> Terms:
    """Return the terms of bounces."""
    count = (flown.linear.nuisance_count - STATE_SIZE) // KICK_SIZE
    impacts = [_ends(arc, len(flown.states)) for arc in flown.arcs[:count]]
    return Terms.together([_of_kicks(flown.linear, impacts), _of_jumps(flown, impacts)])


def _of_kicks(linear: Linearised, impacts: list[Floats]) -> Terms:
    """Return kicks, each times every factor of the (B, 9) states before a bounce."""
    positions = np.zeros((*linear.positions.shape[:3], len(KICKS), len(FACTORS)))
    labels = np.zeros((*linear.labels.shape[:3], len(KICKS), len(FACTORS)))
    for number, states in enumerate(impacts):
        factor = np.nan_to_num(_factors(states))[:, None, None, None]
        start = STATE_SIZE + KICK_SIZE * number
        kicks = slice(start, start + KICK_SIZE)
        positions += linear.positions[..., kicks, None] * factor
        labels += linear.labels[..., kicks, None] * factor
    names = [Term("table", f"{kick} {factor}".strip()) for kick in KICKS for factor in FACTORS]
    width = len(names)
    return Terms(
        tuple(names),
        positions.reshape(*positions.shape[:3], width),
        labels.reshape(*labels.shape[:3], width),
    )


def _factors(states: Floats) -> Floats:
    """Return (B, F) the ``FACTORS`` of (B, 9) states before a bounce, NaN where there is none."""
    x, y, _, vx, vy, _, wx, wy, _ = states.T
    fall = _fall(states)
    slip = np.hypot(vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx)
    factors = [
        fall / fall,
        fall / TYPICAL_FALL,
        slip / TYPICAL_FALL,
        BALL_RADIUS * np.hypot(wx, wy) / TYPICAL_FALL,
        TYPICAL_FALL / fall,
        vx / fall,
        vy / fall,
        1 / (1 + (slip / fall) ** 2),
        x,
        y,
    ]
    return np.stack(factors, axis=1)


def _of_jumps(flown: Flown, impacts: list[Floats]) -> Terms:
    """Return jumps of the state after bounces, given the (B, 9) states before them."""
    count, width, _ = flown.states.shape
    changes = np.zeros((count, width, STATE_SIZE, len(JUMPS)))
    for number, before in enumerate(impacts[: len(flown.arcs) - 1]):
        after = _starts(flown.arcs[number + 1], count)
        jumps = np.nan_to_num(_jumps(before, after))
        changes += after_jump(flown.arcs, number, jumps, width)
    return flown.measured_changes([Term("table", name) for name in JUMPS], changes)


def _jumps(before: Floats, after: Floats) -> Floats:
    """Return the (B, 9, J) jumps at bounces, given the (B, 9) states before and after them.

    A surface higher by h is met h / |v_z| earlier, when the ball fell less fast.
    """
    fall = _fall(before)
    blows = np.zeros((2, *before.shape))
    blows[0, :, VELOCITY.start] = blows[1, :, VELOCITY.start + 1] = fall
    higher = np.zeros(before.shape)
    higher[:, POSITION] = (after - before)[:, VELOCITY] / fall[:, None]
    higher[:, VELOCITY.stop - 1] = -GRAVITY / fall * higher[:, POSITION.stop - 1]
    at_x, at_y = higher * before[:, [0]], higher * before[:, [1]]
    return np.stack([*blows, higher, at_x, at_y], axis=-1)


def _fall(states: Floats) -> Floats:
    return np.maximum(np.abs(states[:, VELOCITY.stop - 1]), SLOWEST_FALL)


def _ends(arc: Arc, count: int) -> Floats:
    """Return the (B, 9) states where an arc ends with a bounce, else NaN."""
    last = arc.inside.argmax(axis=1) + arc.inside.sum(axis=1) - 1
    return _states(arc, last, np.asarray(arc.beyond.any(axis=1)), count)


def _starts(arc: Arc, count: int) -> Floats:
    """Return the (B, 9) states at the start of an arc, NaN of balls without it."""
    return _states(arc, arc.inside.argmax(axis=1), np.ones(len(arc.rows), dtype=bool), count)


def _states(arc: Arc, place: Indices, wanted: Bools, count: int) -> Floats:
    states = np.full((count, STATE_SIZE), np.nan)
    some = wanted & arc.inside.any(axis=1)
    states[arc.rows[some]] = arc.states[some, place[some]]
    return states
