"""Roll-out: flight between contacts whose instants are located exactly inside the step.

Steps are at most 5 ms. A step that comes near a surface is scanned for the first touch along its
cubic, each look as far ahead as the gap allows, and the touch is then located on the Runge-Kutta
step itself, so that the contact time carries the accuracy of the flight.
"""

import math

import numpy as np

from models.ball.compose import compiled
from models.ball.contact import (
    NET,
    NONE,
    TABLE,
    bounced,
    net_gap,
    struck,
    surfaces,
    table_gap,
)
from models.ball.flight import derivative, hall, moved, step
from models.ball.state import BALL_RADIUS, NET_HEIGHT, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH

LONGEST_STEP = 0.005  # s; with Runge-Kutta 5e-9 m at 20 m/s and 600 rad/s
SCAN_DISTANCE = 0.002  # m that the ball travels at least between two looks for a touch
SLIDE_DISTANCE = 0.005  # m that a resting ball slides at most before the next look
MARGIN = 0.006  # m by which a step's path may leave its chord
TIME_TOLERANCE = 1e-14  # s
TIE = 1e-12  # s; contacts nearer than this are at once
REST_SPEED = 5e-4  # m/s: a slower rebound comes back within 0.1 ms and counts as resting
MOST_REBOUNDS = 100  # within a step; a ball pressed to a surface that hard counts as resting, too
MAX_CONTACTS = 8  # contacts recorded a shot; further ones still happen


@compiled
def _near(a, b, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return whether the box around a step's end points comes near the table or the net.

    Nearly every step is told apart by one comparison, so what the rest needs is computed late.
    """
    has_table, has_net, height, up = scene
    reach = BALL_RADIUS + MARGIN
    if has_table:
        slope = (abs(up[0]) * TABLE_HALF_WIDTH + abs(up[1]) * TABLE_HALF_LENGTH) / up[2]
        if min(a[2], b[2]) < height + slope + reach and max(a[2], b[2]) > height - slope - reach:
            beside = min(abs(a[0]), abs(b[0])) > TABLE_HALF_WIDTH + reach
            beyond = min(abs(a[1]), abs(b[1])) > TABLE_HALF_LENGTH + reach
            if not beside and not beyond:
                return True
    if has_net and min(a[1], b[1]) < reach and max(a[1], b[1]) > -reach:
        above = height + NET_HEIGHT + reach
        return min(a[2], b[2]) < above and max(a[2], b[2]) > height - reach
    return False


@compiled
def _gap(surface, x, y, z, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the gap to a surface and its normal; a surface that is not there is never near."""
    has_table, has_net, height, up = scene
    if surface == TABLE and has_table:
        return table_gap(x, y, z, height, up)
    if surface == NET and has_net:
        return net_gap(x, y, z, height)
    return math.inf, (0.0, 0.0, 1.0)


@compiled
def _clearance(x, y, z, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return min(_gap(TABLE, x, y, z, scene)[0], _gap(NET, x, y, z, scene)[0])


@compiled
def _approach(state, normal):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return state[3] * normal[0] + state[4] * normal[1] + state[5] * normal[2]


@compiled
def _cubic(a, b, h, s):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the position at share ``s`` of a step: the cubic through both ends' states."""
    from_a = (1.0 + 2.0 * s) * (1.0 - s) ** 2
    from_b = s * s * (3.0 - 2.0 * s)
    slope_a = h * s * (1.0 - s) ** 2
    slope_b = h * s * s * (s - 1.0)
    return (
        from_a * a[0] + from_b * b[0] + slope_a * a[3] + slope_b * b[3],
        from_a * a[1] + from_b * b[1] + slope_a * a[4] + slope_b * b[4],
        from_a * a[2] + from_b * b[2] + slope_a * a[5] + slope_b * b[5],
    )


@compiled
def _enters(surface, state, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    gap, normal = _gap(surface, state[0], state[1], state[2], scene)
    return gap < 0.0 and _approach(state, normal) < 0.0


@compiled
def _first_touch(a, b, h, p, air, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return a bracket (before, after) in seconds of the first touch, or (h, h) without one."""
    speed = max(math.sqrt(max(_squared_speed(a), _squared_speed(b))), 1e-3)
    clear = now = 0.0
    gap = _clearance(a[0], a[1], a[2], scene)
    while now < h:
        now = min(now + max(gap, SCAN_DISTANCE) / speed, h)
        x, y, z = _cubic(a, b, h, now / h)
        gap = _clearance(x, y, z, scene)
        if gap < 0.0:
            state = b if now == h else step(a, now, p, air)
            if _enters(TABLE, state, scene) or _enters(NET, state, scene):
                return clear, now
        else:
            clear = now
    return h, h


@compiled
def _squared_speed(state):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return state[3] ** 2 + state[4] ** 2 + state[5] ** 2


@compiled
def _locate(a, before, after, surface, p, air, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the state at the touch inside a bracket, and its time: Newton, kept by bisection."""
    moment = after
    state = step(a, moment, p, air)
    for _ in range(60):
        gap, normal = _gap(surface, state[0], state[1], state[2], scene)
        speed = _approach(state, normal)
        if gap < 0.0 and speed < 0.0:
            after = moment
        else:  # still outside, or inside and on its way out
            before = moment
        guess = moment - gap / speed if speed < 0.0 else before
        if not before < guess < after:
            guess = 0.5 * (before + after)
        shift = abs(guess - moment)
        moment = guess
        state = step(a, moment, p, air)
        if shift < TIME_TOLERANCE:
            break
    return state, moment


@compiled
def _contact(a, before, after, p, air, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return state, time, normal and surface of the first contact inside a bracket.

    A tie goes to the surface that it meets faster: one on which it rests it meets all the time.
    """
    end = step(a, after, p, air)
    contact, moment, along, surface = end, math.inf, (0.0, 0.0, 1.0), NONE
    for candidate in (TABLE, NET):
        if not _enters(candidate, end, scene):
            continue
        state, touched = _locate(a, before, after, candidate, p, air, scene)
        _, normal = _gap(candidate, state[0], state[1], state[2], scene)
        faster = _approach(state, normal) < _approach(contact, along)
        if touched < moment - TIE or (touched < moment + TIE and faster):
            contact, moment, along, surface = state, touched, normal, candidate
    return contact, moment, along, surface


@compiled
def _along_surface(state, slope, normal, h):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the state after ``h`` seconds at the part of a constant slope along a surface."""
    nx, ny, nz = normal
    vx, vy, vz, ax, ay, az, wx, wy, wz = slope
    v = vx * nx + vy * ny + vz * nz
    a = ax * nx + ay * ny + az * nz
    flat = (vx - v * nx, vy - v * ny, vz - v * nz, ax - a * nx, ay - a * ny, az - a * nz)
    return moved(state, (*flat, wx, wy, wz), h)


@compiled
def _rest(state, normal, surface, longest, p, air, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the state of a ball that rests on a surface a moment later, and that moment.

    It flies on in the plane of the surface, without rolling friction (midpoint rule).
    """
    along = _approach(state, normal)
    state = (
        state[0],
        state[1],
        state[2],
        state[3] - along * normal[0],
        state[4] - along * normal[1],
        state[5] - along * normal[2],
        state[6],
        state[7],
        state[8],
    )
    h = min(longest, SLIDE_DISTANCE / max(math.sqrt(_squared_speed(state)), 1e-3))
    half = _along_surface(state, derivative(state, p, air), normal, 0.5 * h)
    state = _along_surface(state, derivative(half, p, air), normal, h)
    other = NET if surface == TABLE else TABLE
    return _lifted(other, state, p, air, scene), h


@compiled
def _lifted(surface, state, p, air, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return a ball that slid into a surface just outside of it, slowed by what the way cost."""
    gap, normal = _gap(surface, state[0], state[1], state[2], scene)
    if gap >= 0.0:
        return state
    nx, ny, nz = normal
    pull = min(_approach(derivative(state, p, air), normal), 0.0)
    along = _approach(state, normal)
    slower = -math.sqrt(max(along * along + 2.0 * pull * -gap, 0.0)) if along < 0.0 else along
    kick = slower - along
    shift = (-gap * nx, -gap * ny, -gap * nz, kick * nx, kick * ny, kick * nz, 0.0, 0.0, 0.0)
    return moved(state, shift, 1.0)


@compiled
def _rests(state, normal, p, air):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return whether a ball hardly leaves a surface against which it is pressed."""
    pull = _approach(derivative(state, p, air), normal)
    return _approach(state, normal) < REST_SPEED and pull <= 0.0


@compiled
def _through(state, ahead, h, start, p, air, scene, log, record):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the state at the end of a step that comes near a surface, and the contacts so far.

    ``ahead`` is where the step would end without contacts; every contact goes into the record.
    """
    times, kinds, before, after = record
    left, rebounds = h, 0
    while True:
        clear, touched = _first_touch(state, ahead, left, p, air, scene)
        if clear == left:
            return ahead, log
        contact, moment, normal, surface = _contact(state, clear, touched, p, air, scene)
        state = bounced(contact, normal, surface, p)
        if _approach(contact, normal) < -REST_SPEED:
            if log < MAX_CONTACTS:
                times[log], kinds[log] = start + h - left + moment, surface
                _store(contact, before[log])
                _store(state, after[log])
            log += 1
        left -= moment
        rebounds += 1
        if rebounds > MOST_REBOUNDS or _rests(state, normal, p, air):
            state, passed = _rest(state, normal, surface, left, p, air, scene)
            left -= passed
        ahead = step(state, left, p, air)


@compiled
def _released(state, p, scene):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the first state; one measured a little inside a surface bounces at once."""
    for surface in (TABLE, NET):
        if _enters(surface, state, scene):
            _, normal = _gap(surface, state[0], state[1], state[2], scene)
            state = bounced(state, normal, surface, p)
    return state


@compiled
def _backwards(state, span, p, air):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return where a ball in free flight was ``-span`` seconds before."""
    pieces = math.ceil(-span / LONGEST_STEP)
    for _ in range(pieces):
        state = step(state, span / pieces, p, air)
    return state


@compiled
def _fly_one(state, moments, p, air, scene, states, record):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    now, log = 0.0, 0
    for k in range(len(moments)):
        span = moments[k] - now
        if span < 0.0:
            _store(_backwards(state, span, p, air), states[k])
            continue
        if now == 0.0 and span > 0.0:
            state = _released(state, p, scene)
        pieces = max(math.ceil(span / LONGEST_STEP - 1e-9), 1)
        for piece in range(pieces):
            h = span / pieces
            ahead = step(state, h, p, air)
            if _near(state, ahead, scene):
                start = now + piece * h
                state, log = _through(state, ahead, h, start, p, air, scene, log, record)
            else:
                state = ahead
        now = moments[k]
        _store(state, states[k])
    return log


@compiled
def _store(state, row):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    for i in range(9):
        row[i] = state[i]


@compiled
def _load(s):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    return (s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8])


@compiled
def fly(first, moments, p):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
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
    air = hall(p)
    scene = surfaces(p)
    for b in range(count):
        record = (times[b], kinds[b], before[b], after[b])
        contacts[b] = _fly_one(_load(first[b]), moments[b], p, air, scene, states[b], record)
    return states, contacts, times, kinds, before, after


@compiled
def strike(states, normals, velocities, p):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return (B, 9) states just after a racket of (B, 3) normals and velocities met the balls."""
    from_racket = np.empty_like(states)
    for b in range(len(states)):
        n, v = normals[b], velocities[b]
        after = struck(_load(states[b]), (n[0], n[1], n[2]), (v[0], v[1], v[2]), p)
        _store(after, from_racket[b])
    return from_racket
