"""Roll-outs: flight in steps of at most 5 ms, with all contacts.

A ball that hardly rebounds rests on its surface: it slides on, without rolling friction.
"""

import math

import numpy as np

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.contact_detection import (
    approach,
    enters,
    first_contact,
    first_touch,
    gap_to,
    near,
    squared_speed,
)
from rallygap.models.ball.contact_laws import NET, TABLE, bounce, racket_contact, surfaces
from rallygap.models.ball.flight import advance, derivative, flight_environment, step
from rallygap.models.ball.types import (
    Environment,
    Floats,
    Integers,
    Parameters,
    Record,
    Scene,
    State,
    Vector,
)

MAX_STEP = 0.005  # s; with Runge-Kutta 5e-9 m at 20 m/s and 600 rad/s
MAX_REBOUNDS = 100  # within a step; a ball pressed to a surface that hard counts as resting, too
REST_SPEED = 5e-4  # m/s: a slower rebound comes back within 0.1 ms and counts as resting
SLIDE_DISTANCE = 0.005  # m, longest slide of a resting ball per step
MAX_CONTACTS = 8  # contacts recorded a shot; further ones still happen


@compiled
def _along_surface(state: State, slope: State, normal: Vector, h: float) -> State:
    """Return the state after ``h`` seconds at the part of a constant slope along a surface."""
    nx, ny, nz = normal
    vx, vy, vz, ax, ay, az, wx, wy, wz = slope
    v = vx * nx + vy * ny + vz * nz
    a = ax * nx + ay * ny + az * nz
    flat = (vx - v * nx, vy - v * ny, vz - v * nz, ax - a * nx, ay - a * ny, az - a * nz)
    return advance(state, (*flat, wx, wy, wz), h)


@compiled
def _slide(
    state: State,
    normal: Vector,
    surface: int,
    longest: float,
    p: Parameters,
    environment: Environment,
    scene: Scene,
) -> tuple[State, float]:
    """Return the state of a ball that rests on a surface a moment later, and that moment.

    It flies on in the plane of the surface, without rolling friction (midpoint rule).
    """
    out = (0.0, 0.0, 0.0, *normal, 0.0, 0.0, 0.0)
    state = advance(state, out, -approach(state, normal))
    h = min(longest, SLIDE_DISTANCE / max(math.sqrt(squared_speed(state)), 1e-3))
    half = _along_surface(state, derivative(state, p, environment), normal, 0.5 * h)
    state = _along_surface(state, derivative(half, p, environment), normal, h)
    other = NET if surface == TABLE else TABLE
    return _push_out(other, state, p, environment, scene), h


@compiled
def _push_out(
    surface: int, state: State, p: Parameters, environment: Environment, scene: Scene
) -> State:
    """Move a ball that slid into a surface just outside of it, at the same total energy."""
    gap, normal = gap_to(surface, state[0], state[1], state[2], scene)
    if gap >= 0.0:
        return state
    nx, ny, nz = normal
    pull = min(approach(derivative(state, p, environment), normal), 0.0)
    along = approach(state, normal)
    slower = -math.sqrt(max(along * along + 2.0 * pull * -gap, 0.0)) if along < 0.0 else along
    kick = slower - along
    shift = (-gap * nx, -gap * ny, -gap * nz, kick * nx, kick * ny, kick * nz, 0.0, 0.0, 0.0)
    return advance(state, shift, 1.0)


@compiled
def _is_resting(state: State, normal: Vector, p: Parameters, environment: Environment) -> bool:
    """Return whether a ball hardly leaves a surface against which it is pressed."""
    pull = approach(derivative(state, p, environment), normal)
    return approach(state, normal) < REST_SPEED and pull <= 0.0


@compiled
def _fly_through_contacts(
    state: State,
    ahead: State,
    h: float,
    start: float,
    p: Parameters,
    environment: Environment,
    scene: Scene,
    log: int,
    record: Record,
) -> tuple[State, int]:
    """Return the state at the end of a step that comes near a surface, and the contacts so far.

    ``ahead`` is where the step would end without contacts; every contact goes into the record.
    """
    times, kinds, before, after = record
    left, rebounds = h, 0
    while True:
        clear, touched = first_touch(state, ahead, left, p, environment, scene)
        if clear == left:
            return ahead, log
        contact, moment, normal, surface = first_contact(
            state, clear, touched, p, environment, scene
        )
        state = bounce(contact, normal, surface, p)
        if approach(contact, normal) < -REST_SPEED:
            if log < MAX_CONTACTS:
                times[log], kinds[log] = start + h - left + moment, surface
                _store(contact, before[log])
                _store(state, after[log])
            log += 1
        left -= moment
        rebounds += 1
        if rebounds > MAX_REBOUNDS or _is_resting(state, normal, p, environment):
            state, passed = _slide(state, normal, surface, left, p, environment, scene)
            left -= passed
        ahead = step(state, left, p, environment)


@compiled
def _bounce_if_inside(state: State, p: Parameters, scene: Scene) -> State:
    """Return the first state; one measured a little inside a surface bounces at once."""
    for surface in (TABLE, NET):
        if enters(surface, state, scene):
            _, normal = gap_to(surface, state[0], state[1], state[2], scene)
            state = bounce(state, normal, surface, p)
    return state


@compiled
def _fly_backwards(state: State, span: float, p: Parameters, environment: Environment) -> State:
    """Return where a ball in free flight was ``-span`` seconds before."""
    pieces = math.ceil(-span / MAX_STEP)
    for _ in range(pieces):
        state = step(state, span / pieces, p, environment)
    return state


@compiled
def _fly_one(
    state: State,
    moments: Floats,
    p: Parameters,
    environment: Environment,
    scene: Scene,
    states: Floats,
    record: Record,
) -> int:
    now, log = 0.0, 0
    for k in range(len(moments)):
        span = moments[k] - now
        if span < 0.0:
            _store(_fly_backwards(state, span, p, environment), states[k])
            continue
        if span == 0.0:  # a repeated time, such as padding
            _store(state, states[k])
            continue
        if now == 0.0:
            state = _bounce_if_inside(state, p, scene)
        pieces = max(math.ceil(span / MAX_STEP - 1e-9), 1)
        for piece in range(pieces):
            h = span / pieces
            ahead = step(state, h, p, environment)
            if near(state, ahead, scene):
                start = now + piece * h
                state, log = _fly_through_contacts(
                    state, ahead, h, start, p, environment, scene, log, record
                )
            else:
                state = ahead
        now = moments[k]
        _store(state, states[k])
    return log


@compiled
def _store(state: State, row: Floats) -> None:
    for i in range(9):
        row[i] = state[i]


@compiled
def _load(s: Floats) -> State:
    return (s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8])


@compiled
def fly(
    first: Floats, moments: Floats, p: Parameters
) -> tuple[Floats, Integers, Floats, Integers, Floats, Floats]:
    """Roll out many balls.

    Args:
        first: (B, 9) states at time zero.
        moments: (B, T) times in s, not falling along T; those before zero see free flight only.
        p: parameter vector of the simulator.

    Returns:
        (B, T, 9) states, (B,) number of contacts, (B, K) contact times (NaN beyond the last),
        (B, K) surfaces, (B, K, 9) states just before and (B, K, 9) just after each contact.
    """
    count, length = moments.shape
    states = np.empty((count, length, 9))
    contacts = np.zeros(count, dtype=np.int64)
    times = np.full((count, MAX_CONTACTS), np.nan)
    kinds = np.zeros((count, MAX_CONTACTS), dtype=np.int64)
    before = np.full((count, MAX_CONTACTS, 9), np.nan)
    after = np.full((count, MAX_CONTACTS, 9), np.nan)
    environment = flight_environment(p)
    scene = surfaces(p)
    for b in range(count):
        record = (times[b], kinds[b], before[b], after[b])
        contacts[b] = _fly_one(
            _load(first[b]), moments[b], p, environment, scene, states[b], record
        )
    return states, contacts, times, kinds, before, after


@compiled
def strike(states: Floats, normals: Floats, velocities: Floats, p: Parameters) -> Floats:
    """Return (B, 9) states just after a racket of (B, 3) normals and velocities met the balls."""
    from_racket = np.empty_like(states)
    for b in range(len(states)):
        n, v = normals[b], velocities[b]
        after = racket_contact(_load(states[b]), (n[0], n[1], n[2]), (v[0], v[1], v[2]), p)
        _store(after, from_racket[b])
    return from_racket
