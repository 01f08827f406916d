"""Doubts about units of time and position, about axes, and about the origin."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.contacts import Contact
from rallygap.pipeline.gap.data_check.doubt import Doubt, Setup
from rallygap.pipeline.gap.data_check.measured import Fall, Measured, bounce_places
from rallygap.pipeline.gap.data_check.spins import GRAVITY, is_opposite
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.sources.conversion import POSITION_UNITS, TIME_UNITS

# m/s^2 of a falling ball, with the lift of any spin; between units lies a factor of ten or more.
FALLS = (1.0, 60.0)
LIKELY_FALLS = (6.0, 15.0)  # m/s^2 beyond which lift is an unlikely explanation
TILT = 30.0  # degrees between gravity and -z; less may be lift
EXTENTS = (0.2, 15.0)  # m, largest extent of a typical recording

DOMINANT = 2.0  # ratio of two axes' components above which one of them is meant
BETTER = 0.2  # share of bounces on the table that an exchange of x and y must add
# The axes across and along the table if one axis, exchanged with z, is vertical.
EXCHANGED = {0: (2, 1), 1: (0, 2), 2: (0, 1)}

BAND = 0.06  # m to either side of the most frequent height
FEWEST_BOUNCES = 3
LEAST_SHARE = 0.5  # of all bounces at the most frequent height
WRONG, DOUBTFUL = 0.10, 0.04  # m from the expected height
FLOOR = 0.76  # m from the floor to the table's surface, ITTF Law 2.1
NEAR_FLOOR = 0.01  # m, within which the official height is meant
STEEP = 0.03  # slope of the surface that bounces show
FEWEST_SLOPE = 10  # bounces that show a slope
EDGE = 0.05  # m beyond the table, for errors of positions
FEWEST_PLACED = 5  # bounces that show where the table is

Order = tuple[int, int, int]


def impossible_units(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with units, from the frame interval and from how fast the ball falls."""
    units, changes, wrong = setup.units, {}, []
    second, metre = measured.second, _metre(measured, setup)
    if second != 1:
        changes["time"] = _unit(TIME_UNITS, TIME_UNITS[units.time] * second)
        wrong.append(f"t is not in {units.time}: samples would be {measured.step:.4g} s apart")
    if metre != 1:
        changes["position"] = _unit(POSITION_UNITS, POSITION_UNITS[units.position] * metre)
        extent = f"recordings would extend over {measured.extent:.4g} m"
        wrong.append(f"positions are not in {units.position}: {extent}")
    if wrong:
        guesses = " and ".join(unit or "another unit" for unit in changes.values())
        line = setup.units_line(**changes) if all(changes.values()) else ""
        yield Doubt(f"{', and '.join(wrong)}; {guesses}?", impossible=True, line=line)
    fall = measured.fall
    if fall is not None and fall.size > FALLS[1]:
        text = f"the ball falls with {fall.size:.3g} m/s^2: are t in s and positions in m?"
        yield Doubt(text, impossible=True)


def impossible_axes(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield which axes are exchanged or turned around.

    Gravity points along -z, and balls fly along y rather than across the table.
    """
    fall = measured.fall
    if fall is None:
        return
    axis, sign = _up(fall, measured.flights.contacts)
    across, along = EXCHANGED[axis]
    if _flies_across(measured, fall, (across, along), sign * np.eye(3)[axis]):
        across, along = along, across
    order = (across, along, axis)
    if order == (0, 1, 2) and sign > 0:
        return
    if axis == 2 and sign > 0:
        text = "x and y are exchanged: balls fly along x, and bounces are off the table"
    else:
        text = (
            f"{'' if sign > 0 else '-'}{'xyz'[axis]} points up, not z: the ball falls with "
            f"{', '.join(f'{value:.1f}' for value in fall.acceleration)} m/s^2 along x, y, z"
        )
    yield Doubt(text, impossible=True, line=_axes_line(order, sign, measured, setup))


def impossible_heights(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with heights: a ball on the table has its centre 20 mm above z = 0."""
    height, share = _usual_height(measured.bounces)
    if share < LEAST_SHARE or abs(height - BALL_RADIUS) < WRONG:
        return
    surface = height - BALL_RADIUS
    from_floor = abs(surface - FLOOR) < NEAR_FLOOR
    offset = np.array([0.0, 0.0, -FLOOR if from_floor else -round(surface, 3)])
    origin = "the floor" if abs(surface - FLOOR) < BAND else "another place"
    text = f"heights are from {origin}, not the table: balls bounce at z = {height:.3f} m, not 0.02"
    yield Doubt(text, impossible=True, line=setup.frame_line(np.eye(3), offset))


def fall_doubts(measured: Measured) -> Iterator[Doubt]:
    """Yield what is unusual about how balls fly and fall."""
    fall = measured.fall
    if fall is None:
        return
    if _mostly_across(fall.velocities):
        yield Doubt("balls fly along x, across the table: check that y is along it")
    tilt = np.degrees(np.arccos(np.clip(-fall.acceleration[2] / fall.size, -1.0, 1.0)))
    if tilt > TILT:
        yield Doubt(f"gravity and mean lift point {tilt:.0f} degrees off -z: check the axes")
    if not _within(fall.size, LIKELY_FALLS):
        yield Doubt(
            f"the ball falls with {fall.size:.1f} m/s^2 instead of {GRAVITY}, lift included: check "
            "the units"
        )


def height_doubts(measured: Measured) -> Iterator[Doubt]:
    """Yield what is unusual about the heights of bounces."""
    height, share = _usual_height(measured.bounces)
    if share >= LEAST_SHARE and abs(height - BALL_RADIUS) > DOUBTFUL:
        yield Doubt(
            f"balls bounce at z = {1000 * height:.0f} mm; on the table it is 20 mm: check the "
            "origin of heights"
        )
    slope = _slope(measured.bounces)
    if slope > STEEP:
        yield Doubt(
            f"the heights of bounces rise by {1000 * slope:.0f} mm/m over the table: check the "
            "axes' directions"
        )


def origin_doubts(measured: Measured) -> Iterator[Doubt]:
    """Yield whether bounces are off the table."""
    places = measured.bounces
    if len(places) >= FEWEST_PLACED and _share_on_table(places) < 0.5:
        x, y = np.median(places[:, :2], axis=0)
        yield Doubt(
            f"most bounces are outside the table, typically at x = {x:.2f} m and y = {y:.2f} m: "
            "check that the origin is at the table's centre"
        )


def _metre(measured: Measured, setup: Setup) -> float:
    """Return how many units of positions make a metre; 1 where no unit explains the fall better."""
    fall, extent = measured.fall, measured.extent
    if fall is None or _within(fall.size, FALLS):
        return 1.0
    scales = np.array(list(POSITION_UNITS.values())) / POSITION_UNITS[setup.units.position]
    possible = [
        scale
        for scale in scales
        if _within(fall.size / scale, FALLS) and _within(extent / scale, EXTENTS)
    ]
    return min(possible, key=lambda scale: abs(np.log(fall.size / scale / GRAVITY)), default=1.0)


def _unit(units: Mapping[str, float], number: float) -> str:
    """Return the unit of which so many make an SI unit; empty if there is none."""
    return next((name for name, size in units.items() if abs(size / number - 1) < 1e-6), "")


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _up(fall: Fall, contacts: Sequence[Contact]) -> tuple[int, int]:
    """Return the axis that gravity acts along, and the sign of its upward direction.

    It is z unless another axis explains the fall far better, and no fewer bounces.
    """
    gravity = fall.acceleration
    axis = int(np.argmax(np.abs(gravity)))
    sign = -int(np.sign(gravity[axis]))
    if (axis, sign) == (2, 1) or (axis != 2 and abs(gravity[axis]) < DOMINANT * abs(gravity[2])):
        return 2, 1
    if _thrown(contacts, axis, sign) < _thrown(contacts, 2, 1):
        return 2, 1
    return axis, sign


def _thrown(contacts: Sequence[Contact], axis: int, sign: int) -> int:
    """Return how many contacts change the velocity mostly in this direction."""
    changes = np.array([contact.after - contact.before for contact in contacts]).reshape(-1, 3)
    along = sign * changes[:, axis]
    return int((along >= np.abs(changes).max(axis=1, initial=0.0)).sum())


def _flies_across(measured: Measured, fall: Fall, horizontal: tuple[int, int], up: Floats) -> bool:
    """Return whether balls fly along the first of the axes, and bounces say that it is y."""
    places = bounce_places(measured.flights.contacts, up)[:, horizontal]
    if not _mostly_across(fall.velocities[:, horizontal]) or not len(places):
        return False
    return _share_on_table(places[:, ::-1]) >= _share_on_table(places) + BETTER


def _mostly_across(velocities: Floats) -> bool:
    """Return whether (n, 2) or more components of velocities are mostly along the first axis."""
    across, along = np.median(np.abs(velocities), axis=0)[:2]
    return bool(across > DOMINANT * along)


def _share_on_table(places: Floats) -> float:
    """Return the share of (n, 2) or (n, 3) places that are on the table."""
    across, along = TABLE_HALF_WIDTH + EDGE, TABLE_HALF_LENGTH + EDGE
    inside = (np.abs(places[:, 0]) <= across) & (np.abs(places[:, 1]) <= along)
    return float(inside.mean())


def _axes_line(order: Order, sign: int, measured: Measured, setup: Setup) -> str:
    """Return the correction: other axes of the columns, or a rotation of right-handed axes.

    Positions do not tell an exchange of two columns from a rotation, which differ by a mirror. Spin
    labels do.
    """
    exchange = np.eye(3)[list(order)]
    is_mirror = np.linalg.det(exchange) < 0
    is_exchange = sign > 0 and setup.frame == Frame()
    if is_exchange and not (is_mirror and is_opposite(measured.flights.turned(exchange))):
        return setup.axes_line(order)
    rotation = exchange.copy()
    rotation[2] *= sign
    rotation[0] *= np.linalg.det(rotation)
    return setup.frame_line(np.round(rotation), np.zeros(3))


def _usual_height(places: Floats) -> tuple[float, float]:
    """Return the most frequent height of bounces, and the share of bounces near it."""
    heights = places[:, 2]
    if len(heights) < FEWEST_BOUNCES:
        return BALL_RADIUS, 0.0
    near = np.abs(heights[:, None] - heights) < BAND
    most = near[np.argmax(near.sum(axis=1))]
    return float(np.median(heights[most])), float(most.mean())


def _slope(places: Floats) -> float:
    """Return the slope of the plane through the bounces at the most frequent height."""
    chosen = places[np.abs(places[:, 2] - _usual_height(places)[0]) < BAND]
    if len(chosen) < FEWEST_SLOPE:
        return 0.0
    terms = np.column_stack([chosen[:, :2] - chosen[:, :2].mean(axis=0), np.ones(len(chosen))])
    return float(np.linalg.norm(np.linalg.lstsq(terms, chosen[:, 2])[0][:2]))
