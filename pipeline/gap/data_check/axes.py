"""Axes: gravity points along -z, and balls fly along y rather than across the table."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.contacts import Contact
from rallygap.pipeline.gap.data_check.bounces import bounce_places, share_on_table
from rallygap.pipeline.gap.data_check.fall import Fall
from rallygap.pipeline.gap.data_check.flights import Flights
from rallygap.pipeline.gap.data_check.problem import Problem, Setup
from rallygap.pipeline.gap.data_check.spins import is_opposite
from rallygap.pipeline.io.frame import Frame

DOMINANT = 2.0  # ratio of two axes' components above which one of them is meant
BETTER = 0.2  # share of bounces on the table that an exchange of x and y must add
# The axes across and along the table if one axis, exchanged with z, is vertical.
EXCHANGED = {0: (2, 1), 1: (0, 2), 2: (0, 1)}
Order = tuple[int, int, int]


def axes_problem(fall: Fall, flights: Flights, setup: Setup) -> Problem | None:
    """Return which axes are exchanged or turned around."""
    axis, sign = _up(fall, flights.contacts)
    across, along = EXCHANGED[axis]
    if _flies_across(fall.velocities, flights.contacts, (across, along), sign * np.eye(3)[axis]):
        across, along = along, across
    order = (across, along, axis)
    if order == (0, 1, 2) and sign > 0:
        return None
    return Problem(_text(order, sign, fall), _line(order, sign, flights, setup))


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


def _flies_across(
    velocities: Floats, contacts: Sequence[Contact], horizontal: tuple[int, int], up: Floats
) -> bool:
    """Return whether balls fly along the first of the axes, and bounces say that it is y."""
    places = bounce_places(contacts, up)[:, horizontal]
    if not mostly_across(velocities[:, horizontal]) or not len(places):
        return False
    return share_on_table(places[:, ::-1]) >= share_on_table(places) + BETTER


def mostly_across(velocities: Floats) -> bool:
    """Return whether (n, 2) or more components of velocities are mostly along the first axis."""
    across, along = np.median(np.abs(velocities), axis=0)[:2]
    return bool(across > DOMINANT * along)


def _text(order: Order, sign: int, fall: Fall) -> str:
    up = ("" if sign > 0 else "-") + "xyz"[order[2]]
    if order[2] == 2 and sign > 0:
        return "x and y are exchanged: balls fly along x, and bounces are off the table"
    return (
        f"{up} points up, not z: the ball falls with "
        f"{', '.join(f'{one:.1f}' for one in fall.acceleration)} m/s^2 along x, y, z"
    )


def _line(order: Order, sign: int, flights: Flights, setup: Setup) -> str:
    """Return the correction: other axes of the columns, or a rotation of right-handed axes.

    Positions do not tell an exchange of two columns from a rotation, which differ by a mirror. Spin
    labels do.
    """
    exchange = np.eye(3)[list(order)]
    is_mirror = np.linalg.det(exchange) < 0
    is_exchange = sign > 0 and setup.frame == Frame()
    if is_exchange and not (is_mirror and is_opposite(flights.turned(exchange))):
        return setup.axes_line(order)
    rotation = exchange.copy()
    rotation[2] *= sign
    rotation[0] *= np.linalg.det(rotation)
    return setup.frame_line(np.round(rotation), np.zeros(3))
