"""Racket contacts: when and where, within a control step, balls meet rackets."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.robot.constants import RACKET_RADIUS
from rallygap.models.robot.contact import first_contact
from rallygap.models.robot.kinematics import Racket, racket

# Ball and racket farther apart than this at both ends of a millisecond do not meet within it: their
# closing speed would have to exceed 100 m/s.
NEAR = RACKET_RADIUS + BALL_RADIUS + 0.05  # m


@dataclass(frozen=True)
class RacketContacts:
    """The contacts of C balls with their rackets.

    Attributes:
        envs: (C,) indices of their environments, ascending.
        moments: (C,) path steps since the start of the control step.
        states: (C, 9) of the balls just before the contact.
        normals: (C, 3) of the side that meets the ball, pointing to it.
        velocities: (C, 3) m/s, of the racket at the contact point.
        backhand: (C,) whether the racket's back meets the ball.
    """

    envs: Integers
    moments: Floats
    states: Floats
    normals: Floats
    velocities: Floats
    backhand: Bools

    def __getitem__(self, rows: Bools) -> "RacketContacts":
        """Return some of the contacts."""
        return RacketContacts(*(part[rows] for part in vars(self).values()))


def racket_path(joints: Floats, speeds: Floats, substeps: int) -> Floats:
    """Return rackets (S * substeps + 1, B, 12): position, normal, velocity, angular velocity.

    Args:
        joints: (S + 1, B, 6) at the ends of S Bullet steps.
        speeds: (S + 1, B, 6) of the joints.
        substeps: per Bullet step, between which rackets are interpolated linearly.
    """
    ends, count = joints.shape[:2]
    rackets = racket(joints.reshape(ends * count, -1), speeds.reshape(ends * count, -1))
    parts = [rackets.position, rackets.normal, rackets.velocity, rackets.turning]
    poses = np.concatenate(parts, axis=1).reshape(ends, count, 12)
    shares = np.arange(substeps)[:, None, None] / substeps
    between = poses[:-1, None] + shares * np.diff(poses, axis=0)[:, None]
    return np.concatenate([between.reshape(-1, count, 12), poses[-1:]])


def distances(balls: Floats, rackets: Floats) -> Floats:
    """Return (S + 1, B) m, distances between the centres of balls (S + 1, B, 9) and rackets."""
    offset = balls[..., :3] - rackets[..., :3]
    return np.sqrt(np.einsum("sbi,sbi->sb", offset, offset))


def find_contacts(balls: Floats, rackets: Floats, distance: Floats, live: Bools) -> RacketContacts:
    """Return the first contact of each ball with its racket.

    Args:
        balls: (S + 1, B, 9) states at the ends of S path steps.
        rackets: (S + 1, B, 12) at the same times, as ``racket_path`` returns them.
        distance: (S + 1, B) m between their centres.
        live: (S, B) steps in which contacts count.
    """
    near = live & (np.minimum(distance[:-1], distance[1:]) < NEAR)
    envs, steps = np.nonzero(near.T)
    if not len(envs):
        return _contacts(envs, np.zeros(0), balls, rackets, envs)
    before, after = (steps, envs), (steps + 1, envs)
    poses = [Racket(*rackets[k].reshape(-1, 4, 3).swapaxes(0, 1)) for k in (before, after)]
    contact = first_contact(balls[before][:, :3], balls[after][:, :3], *poses)
    met = np.flatnonzero(contact.met)
    envs, first = np.unique(envs[met], return_index=True)
    row = met[first]
    return _contacts(envs, steps[row] + contact.share[row], balls, rackets, contact.side[row])


def _contacts(
    envs: Integers, moments: Floats, balls: Floats, rackets: Floats, sides: Integers
) -> RacketContacts:
    states, poses = _at(balls, envs, moments), _at(rackets, envs, moments)
    position, normal, velocity, turning = poses.reshape(-1, 4, 3).swapaxes(0, 1)
    offset = states[:, :3] - position
    on_disc = offset - np.einsum("ci,ci->c", offset, normal)[:, None] * normal
    return RacketContacts(
        envs,
        moments,
        states,
        normal * sides[:, None],
        velocity + np.cross(turning, on_disc),
        sides < 0,
    )


def _at(rows: Floats, envs: Integers, moments: Floats) -> Floats:
    """Return (C, ...) values interpolated between the rows (S + 1, B, ...) of the moments."""
    step = np.minimum(moments.astype(np.int64), len(rows) - 2)
    share = (moments - step)[:, None]
    return rows[step, envs] + share * (rows[step + 1, envs] - rows[step, envs])
