"""Joint speeds: the racket goes as asked, within every limit."""

import numpy as np
import pytest

from rallygap.models.robot.constants import COMMAND_STEP, JOINTS, LOWER, NEUTRAL, SPEED, UPPER
from rallygap.models.robot.control import DAMPING, HOMING, joint_speeds
from rallygap.models.robot.kinematics import racket

RANDOM = np.random.default_rng(5)
POSES = 0.4 * RANDOM.uniform(LOWER, UPPER, (200, len(JOINTS)))
VELOCITIES = RANDOM.uniform(-1, 1, (200, 3)) * [1.5, 2.5, 2.0]
TURNS = RANDOM.uniform(-6, 6, (200, 2))


def task_rows(joints):
    """What every joint alone does to the five tasks, (B, 5, 6)."""
    alone = [racket(joints, np.tile(one, (len(joints), 1))) for one in np.eye(len(JOINTS))]
    side = alone[5].turning  # the wrist's pitch axis is the racket's side axis
    axes = (side, np.cross(side, alone[0].normal))
    rows = [
        np.column_stack([moved.velocity, *((moved.turning * axis).sum(axis=1) for axis in axes)])
        for moved in alone
    ]
    return np.stack(rows, axis=2)


def test_slow_motions_are_the_best_compromise_of_task_effort_and_home():
    tasks = 0.1 * np.hstack([VELOCITIES, TURNS])
    speeds = joint_speeds(POSES, tasks[:, :3], tasks[:, 3:])
    home = HOMING * (NEUTRAL - POSES)
    for rows, task, wish, found in zip(task_rows(POSES), tasks, home, speeds, strict=True):
        # The minimum of |rows q - task|^2 + lambda^2 |q - home|^2, by least squares.
        stacked = np.vstack([rows, np.sqrt(DAMPING) * np.eye(len(JOINTS))])
        aims = np.concatenate([task, np.sqrt(DAMPING) * wish])
        np.testing.assert_allclose(found, np.linalg.lstsq(stacked, aims)[0], atol=1e-9)


def test_no_joint_is_asked_for_more_than_its_speed():
    fast = joint_speeds(POSES, 10 * VELOCITIES, 10 * TURNS)
    assert (np.abs(fast) <= SPEED * (1 + 1e-12)).all()
    assert np.max(np.abs(fast) / SPEED, axis=1).mean() > 0.9


@pytest.mark.parametrize("end", [LOWER, UPPER])
def test_at_an_end_no_joint_is_driven_beyond(end):
    poses = np.broadcast_to(end, POSES.shape)
    after = poses + COMMAND_STEP * joint_speeds(poses, VELOCITIES, TURNS)
    assert ((after >= LOWER - 1e-12) & (after <= UPPER + 1e-12)).all()


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"turning rates \(200, 2\)"):
        joint_speeds(POSES, VELOCITIES[:, :2], TURNS)
    with pytest.raises(ValueError, match=r"\(B, 6\)"):
        joint_speeds(POSES[:, :5], VELOCITIES, TURNS)
