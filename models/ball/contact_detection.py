"""Detection of the first contact with table or net within a step of flight.

A step near a surface is scanned along its cubic interpolation, with steps as long as the gap
allows. The contact is then located on the Runge-Kutta step itself, so that the contact time has the
accuracy of the flight.
"""

import math

from rallygap.models.ball.compose import compiled
from rallygap.models.ball.contact_laws import NET, NONE, TABLE, net_gap, table_gap
from rallygap.models.ball.flight import step
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Environment, Parameters, Scene, State, Vector

SCAN_DISTANCE = 0.002  # m, shortest distance between two samples of the scan
SCAN_SAMPLES = 1000  # most samples within a step of flight; enough below 400 m/s
MARGIN = 0.006  # m by which a step's path may leave its chord
TIME_TOLERANCE = 1e-14  # s
TIE = 1e-12  # s; contacts closer than this are simultaneous


@compiled
def near(a: State, b: State, scene: Scene) -> bool:
    """Return whether the box around a step's end points comes near the table or the net.

    One comparison decides nearly every step, so the other terms are computed only when needed.
    """
    has_table, has_net, height, up = scene
    reach = BALL_RADIUS + MARGIN
    if has_table:
        slope = (abs(up[0]) * TABLE_HALF_WIDTH + abs(up[1]) * TABLE_HALF_LENGTH) / up[2]
        if min(a[2], b[2]) < height + slope + reach and max(a[2], b[2]) > height - slope - reach:
            outside_x = min(abs(a[0]), abs(b[0])) > TABLE_HALF_WIDTH + reach
            outside_y = min(abs(a[1]), abs(b[1])) > TABLE_HALF_LENGTH + reach
            if not outside_x and not outside_y:
                return True
    if has_net and min(a[1], b[1]) < reach and max(a[1], b[1]) > -reach:
        above = height + NET_HEIGHT + reach
        return min(a[2], b[2]) < above and max(a[2], b[2]) > height - reach
    return False


@compiled
def gap_to(surface: int, x: float, y: float, z: float, scene: Scene) -> tuple[float, Vector]:
    """Return the gap to a surface and its normal; infinite for an absent surface."""
    has_table, has_net, height, up = scene
    if surface == TABLE and has_table:
        return table_gap(x, y, z, height, up)
    if surface == NET and has_net:
        return net_gap(x, y, z, height)
    return math.inf, (0.0, 0.0, 1.0)


@compiled
def _clearance(x: float, y: float, z: float, scene: Scene) -> float:
    return min(gap_to(TABLE, x, y, z, scene)[0], gap_to(NET, x, y, z, scene)[0])


@compiled
def approach(state: State, normal: Vector) -> float:
    """Return the velocity along a normal, negative where the ball comes towards the surface."""
    return state[3] * normal[0] + state[4] * normal[1] + state[5] * normal[2]


@compiled
def enters(surface: int, state: State, scene: Scene) -> bool:
    """Return whether a ball touches a surface and moves further into it."""
    gap, normal = gap_to(surface, state[0], state[1], state[2], scene)
    return gap < 0.0 and approach(state, normal) < 0.0


@compiled
def squared_speed(state: State) -> float:
    """Return |v|^2 in m^2/s^2."""
    return state[3] ** 2 + state[4] ** 2 + state[5] ** 2


@compiled
def _cubic(a: State, b: State, h: float, s: float) -> Vector:
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
def first_touch(
    a: State, b: State, h: float, p: Parameters, environment: Environment, scene: Scene
) -> tuple[float, float]:
    """Return a bracket (before, after) in seconds of the first touch, or (h, h) without one."""
    speed = max(math.sqrt(max(squared_speed(a), squared_speed(b))), 1e-3)
    shortest = max(SCAN_DISTANCE / speed, h / SCAN_SAMPLES)
    clear = now = 0.0
    gap = _clearance(a[0], a[1], a[2], scene)
    while now < h:
        now = min(now + max(gap / speed, shortest), h)
        x, y, z = _cubic(a, b, h, now / h)
        gap = _clearance(x, y, z, scene)
        if gap < 0.0:
            state = b if now == h else step(a, now, p, environment)
            if enters(TABLE, state, scene) or enters(NET, state, scene):
                return clear, now
        else:
            clear = now
    return h, h


@compiled
def _locate(
    a: State,
    before: float,
    after: float,
    surface: int,
    p: Parameters,
    environment: Environment,
    scene: Scene,
) -> tuple[State, float]:
    """Return state and time of the touch inside a bracket (Newton's method with bisection)."""
    moment = after
    state = step(a, moment, p, environment)
    for _ in range(60):
        gap, normal = gap_to(surface, state[0], state[1], state[2], scene)
        speed = approach(state, normal)
        if gap < 0.0 and speed < 0.0:
            after = moment
        else:  # still outside, or inside and on its way out
            before = moment
        guess = moment - gap / speed if speed < 0.0 else before
        if not before < guess < after:
            guess = 0.5 * (before + after)
        shift = abs(guess - moment)
        moment = guess
        state = step(a, moment, p, environment)
        if shift < TIME_TOLERANCE:
            break
    return state, moment


@compiled
def first_contact(
    a: State, before: float, after: float, p: Parameters, environment: Environment, scene: Scene
) -> tuple[State, float, Vector, int]:
    """Return state, time, normal and surface of the first contact inside a bracket.

    Of two simultaneous contacts, the faster one counts: a ball at rest touches its surface always.
    """
    end = step(a, after, p, environment)
    contact, moment, along, surface = end, math.inf, (0.0, 0.0, 1.0), NONE
    for candidate in (TABLE, NET):
        if not enters(candidate, end, scene):
            continue
        state, touched = _locate(a, before, after, candidate, p, environment, scene)
        _, normal = gap_to(candidate, state[0], state[1], state[2], scene)
        faster = approach(state, normal) < approach(contact, along)
        if touched < moment - TIE or (touched < moment + TIE and faster):
            contact, moment, along, surface = state, touched, normal, candidate
    return contact, moment, along, surface
