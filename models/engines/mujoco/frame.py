"""The table frame in a scene: where the playing surface lies, and states in both frames.

The playing surface is the top of one box, or of several boxes side by side, of the size of a table
that the ball can collide with. The frame's origin is the centre of the surface, z its normal, away
from gravity, and y its long axis. Nothing in a scene tells the two ends of a table apart: y points
along the world's axis to which the long axis is nearest, in its positive direction (x before y).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from rallygap.models.ball.state import POSITION, SPIN, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.ball import Ball
from rallygap.models.engines.mujoco.simulation import initial_data

SIZE_TOLERANCE = 0.05  # of the table's length and width, relative
COPLANAR = 2e-3  # m, between the tops of boxes that are one surface
PARALLEL = 0.9998  # cosine: within a degree
LEVEL = 0.97  # cosine: within fourteen degrees
COVERED = 0.95  # share of the surface's rectangle that its boxes cover, at least


@dataclass(frozen=True, eq=False)
class TableFrame:
    """The table frame in the world of a scene.

    Attributes:
        origin: (3,) m, the centre of the playing surface.
        axes: (3, 3), its columns are the frame's axes.
        geoms: the boxes that are the playing surface; none where no table is found. Then the
            world's frame is the table frame.
        length: m, along y; 0 without a table.
        width: m, along x; 0 without a table.
    """

    origin: Floats
    axes: Floats
    geoms: tuple[int, ...]
    length: float
    width: float

    @property
    def found(self) -> bool:
        """Whether the scene has a table."""
        return bool(self.geoms)

    def to_world(self, states: Floats) -> Floats:
        """Return (..., 9) states of the table frame in the world's frame."""
        turned = _turned(states, self.axes.T)
        turned[..., POSITION] += self.origin
        return turned

    def to_table(self, states: Floats) -> Floats:
        """Return (..., 9) states of the world's frame in the table frame."""
        moved = states.copy()
        moved[..., POSITION] -= self.origin
        return _turned(moved, self.axes)


WORLD = TableFrame(np.zeros(3), np.eye(3), (), 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class _Plate:
    """The top of a box: its centre, its axes (columns: two edges, normal) and its half sizes."""

    geom: int
    centre: Floats
    axes: Floats
    half: Floats


def find_frame(model: mujoco.MjModel, ball: Ball) -> TableFrame:
    """Find the table in a scene at its start; without one, the world's frame is the table frame.

    Of several tables, the highest is taken.
    """
    size = float(np.linalg.norm(model.opt.gravity))
    up = np.array([0.0, 0.0, 1.0]) if size == 0.0 else -model.opt.gravity / size
    plates = list(_plates(model, ball, up))
    frames = [frame for surface in _surfaces(plates) if (frame := _frame(surface)) is not None]
    return max(frames, key=lambda frame: float(frame.origin @ up), default=WORLD)


def _turned(states: Floats, axes: Floats) -> Floats:
    turned = np.empty_like(states)
    for part in (POSITION, VELOCITY, SPIN):
        turned[..., part] = states[..., part] @ axes
    return turned


def _plates(model: mujoco.MjModel, ball: Ball, up: Floats) -> Iterator[_Plate]:
    """Yield the most upward sides of boxes that the ball can collide with, where they are level."""
    data = initial_data(model)
    for box in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_BOX).tolist():
        if not _meets(model, ball.geom, box):
            continue
        axes, half = data.geom_xmat[box].reshape(3, 3), model.geom_size[box]
        vertical = int(np.argmax(np.abs(up @ axes)))
        edges = [axis for axis in range(3) if axis != vertical]
        normal = axes[:, vertical] * np.sign(up @ axes[:, vertical])
        if normal @ up > LEVEL:
            centre = data.geom_xpos[box] + half[vertical] * normal
            yield _Plate(box, centre, np.column_stack([axes[:, edges], normal]), half[edges])


def _surfaces(plates: list[_Plate]) -> Iterator[list[_Plate]]:
    """Yield every plate alone, and with all others of its plane and direction."""
    for plate in plates:
        yield [plate]
        yield [other for other in plates if _continues(plate, other)]


def _continues(plate: _Plate, other: _Plate) -> bool:
    along = np.abs(plate.axes.T @ other.axes)
    height = abs(plate.axes[:, 2] @ (other.centre - plate.centre))
    return bool(along[2, 2] > PARALLEL and along[0, :2].max() > PARALLEL and height < COPLANAR)


def _frame(plates: list[_Plate]) -> TableFrame | None:
    """Return the frame of a surface; None if it is no table."""
    first = plates[0]
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    corners = [plate.centre + (signs * plate.half) @ plate.axes[:, :2].T for plate in plates]
    flat = (np.concatenate(corners) - first.centre) @ first.axes[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    sides = high - low
    long, short = (0, 1) if sides[0] >= sides[1] else (1, 0)
    length, width = float(sides[long]), float(sides[short])
    covered = sum(4.0 * float(np.prod(plate.half)) for plate in plates) / float(np.prod(sides))
    relative = np.array([length / (2 * TABLE_HALF_LENGTH), width / (2 * TABLE_HALF_WIDTH)])
    if covered < COVERED or np.abs(relative - 1.0).max() >= SIZE_TOLERANCE:
        return None
    origin = first.centre + first.axes[:, :2] @ ((low + high) / 2)
    along, normal = first.axes[:, long], first.axes[:, 2]
    # Rounded, so that an axis midway between two of the world's has one direction.
    nearest = int(np.argmax(np.round(np.abs(along), 6)))
    y = along * np.sign(along[nearest])
    axes = np.column_stack([np.cross(y, normal), y, normal])
    return TableFrame(origin, axes, tuple(plate.geom for plate in plates), length, width)


def _meets(model: mujoco.MjModel, geom: int, other: int) -> bool:
    """Return whether two geoms can collide."""
    pairs = np.sort(np.column_stack([model.pair_geom1, model.pair_geom2]), axis=1)
    if (pairs == sorted((geom, other))).all(axis=1).any():
        return True
    low, high = sorted((int(model.geom_bodyid[geom]), int(model.geom_bodyid[other])))
    if (low << 16) + high in model.exclude_signature:
        return False
    types, affinities = model.geom_contype[[geom, other]], model.geom_conaffinity[[other, geom]]
    return bool((types & affinities).any())
