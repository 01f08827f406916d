"""Arms in Bullet: limits hold, the table is felt."""

from contextlib import closing

import numpy as np
import pytest

from rallygap.models.robot.arms import Arms
from rallygap.models.robot.constants import (
    BULLET_STEP,
    COMMAND_STEP,
    JOINTS,
    LOWER,
    NEUTRAL,
    SPEED,
    UPPER,
)
from rallygap.models.robot.control import joint_speeds
from rallygap.models.robot.kinematics import racket

STEPS_A_COMMAND = round(COMMAND_STEP / BULLET_STEP)


@pytest.mark.parametrize("towards", [-1, 1])
def test_a_joint_goes_at_its_speed_by_its_force_and_stops_at_its_end(towards):
    """Each arm drives one joint, asked for more than its speed."""
    speeds = []
    with closing(Arms(len(JOINTS))) as arms:
        arms.command(towards * 100 * np.eye(len(JOINTS)))
        for _ in range(250):
            arms.step()
            speeds.append(towards * np.diag(arms.joint_speeds))
        end = LOWER if towards < 0 else UPPER
        np.testing.assert_allclose(np.diag(arms.joints), end, atol=1e-3)
    np.testing.assert_allclose(np.max(speeds, axis=0), SPEED, rtol=0.02)
    for joint in (0, 1):  # the gantry
        seconds = BULLET_STEP * (1 + np.argmax(np.array(speeds)[:, joint] >= 0.99 * SPEED[joint]))
        carried = sum(solid.mass for beyond in JOINTS[joint:] for solid in beyond.link)
        needed = carried * SPEED[joint] / JOINTS[joint].force
        # The arm swings back a little, so that not all of it is carried at once.
        assert 0.75 * needed < seconds < 1.1 * needed


def test_a_racket_driven_into_the_table_touches_it_until_it_is_put_back():
    """It moves over the table and then onto it."""
    with closing(Arms(2)) as arms:
        touching = []
        for velocity in [[0.0, 2.0, 0.0]] * 10 + [[0.0, 0.0, -1.5]] * 15:
            arms.command(joint_speeds(arms.joints, np.tile(velocity, (2, 1)), np.zeros((2, 2))))
            for _ in range(STEPS_A_COMMAND):
                arms.step()
                touching.append(arms.touching_table())
        assert not np.any(touching[: 10 * STEPS_A_COMMAND]) and touching[-1].all()
        assert (racket(arms.joints, arms.joint_speeds).position[:, 2] > -0.01).all()
        arms.reset(np.array([True, False]))
        assert arms.touching_table().tolist() == [False, True]
        np.testing.assert_array_equal(arms.joints[0], NEUTRAL)
        arms.step()
        assert not arms.touching_table()[0]
