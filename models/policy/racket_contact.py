"""Encounter: where, within a control tick, balls and rackets come together."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from models.ball.state import BALL_RADIUS
from models.robot.constants import RACKET_RADIUS
from models.robot.contact import meeting
from models.robot.kinematics import Racket, racket

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

# Ball and racket further apart than this at both ends of a millisecond do not meet within: they
# would have to close in at 100 m/s.
NEAR = RACKET_RADIUS + BALL_RADIUS + 0.05  # m


@dataclass(frozen=True)
class Encounters:
    """The C balls that met a racket.

    Attributes:
        arms: (C,) which, growing.
        moments: (C,) path steps since the start of the tick.
        states: (C, 9) of the balls just before.
        normals: (C, 3) of the side that met the ball, pointing to it.
        velocities: (C, 3) of the racket where it met the ball, m/s.
        backhand: (C,) whether that was the racket's back.
    """

    arms: Integers
    moments: Floats
    states: Floats
    normals: Floats
    velocities: Floats
    backhand: Booleans

    def __getitem__(self, rows: Booleans) -> "Encounters":
        """Return some of the encounters."""
        return Encounters(*(getattr(self, field.name)[rows] for field in fields(self)))


def swing(joints: Floats, speeds: Floats, pieces: int) -> Floats:
    """Return rackets on their way: (S * pieces + 1, B, 12) position, normal, velocity, turning.

    Args:
        joints: (S + 1, B, 6) at the ends of S steps of the arms.
        speeds: (S + 1, B, 6) of the joints.
        pieces: into which a step is divided; the rackets move evenly in between.
    """
    ends, count = joints.shape[:2]
    seen = racket(joints.reshape(ends * count, -1), speeds.reshape(ends * count, -1))
    parts = [seen.position, seen.normal, seen.velocity, seen.turning]
    poses = np.concatenate(parts, axis=1).reshape(ends, count, 12)
    shares = np.arange(pieces)[:, None, None] / pieces
    between = poses[:-1, None] + shares * np.diff(poses, axis=0)[:, None]
    return np.concatenate([between.reshape(-1, count, 12), poses[-1:]])


def distances(balls: Floats, rackets: Floats) -> Floats:
    """Return (S + 1, B) m between the centres of balls (S + 1, B, 9) and rackets."""
    apart = balls[..., :3] - rackets[..., :3]
    between: Floats = np.sqrt(np.einsum("sbi,sbi->sb", apart, apart))
    return between


def encounters(balls: Floats, rackets: Floats, apart: Floats, live: Booleans) -> Encounters:
    """Return the first meetings of balls and rackets.

    Args:
        balls: (S + 1, B, 9) states at the ends of S path steps.
        rackets: (S + 1, B, 12) at the same moments, as ``swing`` returns them.
        apart: (S + 1, B) m between their centres.
        live: (S, B) steps in which a ball can be met.
    """
    near = live & (np.minimum(apart[:-1], apart[1:]) < NEAR)
    arms, steps = np.nonzero(near.T)
    if not len(arms):
        return _met(
            np.zeros(0, dtype=np.int64), np.zeros(0), balls, rackets, np.zeros(0, dtype=np.int64)
        )
    before, after = (steps, arms), (steps + 1, arms)
    found = meeting(
        balls[before][:, :3], balls[after][:, :3], _racket(rackets[before]), _racket(rackets[after])
    )
    met = np.flatnonzero(found.met)
    arms, first = np.unique(arms[met], return_index=True)
    chosen = met[first]
    return _met(arms, steps[chosen] + found.share[chosen], balls, rackets, found.side[chosen])


def _met(
    arms: Integers, moments: Floats, balls: Floats, rackets: Floats, sides: Integers
) -> Encounters:
    states, poses = _at(balls, arms, moments), _at(rackets, arms, moments)
    position, normal, velocity, turning = poses.reshape(-1, 4, 3).swapaxes(0, 1)
    offset = states[:, :3] - position
    on_disc = offset - np.einsum("ci,ci->c", offset, normal)[:, None] * normal
    return Encounters(
        arms,
        moments,
        states,
        normal * sides[:, None],
        velocity + np.cross(turning, on_disc),
        sides < 0,
    )


def _at(rows: Floats, arms: Integers, moments: Floats) -> Floats:
    """Return (C, ...) values of some arms between the rows (S + 1, B, ...) of their moments."""
    step = np.minimum(moments.astype(np.int64), len(rows) - 2)
    share = (moments - step)[:, None]
    between: Floats = rows[step, arms] + share * (rows[step + 1, arms] - rows[step, arms])
    return between


def _racket(poses: Floats) -> Racket:
    return Racket(poses[:, :3], poses[:, 3:6], poses[:, 6:9], poses[:, 9:])
