"""Arms in Bullet: limits hold, the table is felt, the same commands give the same bytes."""

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
FREE = 25  # commands, 0.5 s
EVERYONE = np.ones(4, dtype=bool)


def moves(count, seed=7):
    """Racket velocities and turning rates, one a tick of two commands, that stay off the table."""
    random = np.random.default_rng(seed)
    velocities = random.uniform(-1, 1, (FREE, count, 3)) * [1.0, 1.0, 0.5] + [0.0, -0.2, 0.2]
    return velocities, random.uniform(-4, 4, (FREE, count, 2))


def play(arms, velocities, turns):
    """Joints and joint speeds after every Bullet step, (T, B, 12)."""
    seen = []
    for velocity, turning in zip(velocities, turns, strict=True):
        arms.command(joint_speeds(arms.joints, velocity, turning))
        for _ in range(STEPS_A_COMMAND):
            arms.step()
            seen.append(np.hstack([arms.joints, arms.joint_speeds]))
    return np.array(seen)


def down(arms):
    """Move the rackets over the table and then onto it; return (T, B) whether they touch it."""
    still, seen = np.zeros((len(arms.joints), 2)), []
    for velocity in [[0.0, 2.0, 0.0]] * 10 + [[0.0, 0.0, -1.5]] * 15:
        ask = np.tile(velocity, (len(arms.joints), 1))
        arms.command(joint_speeds(arms.joints, ask, still))
        for _ in range(STEPS_A_COMMAND):
            arms.step()
            seen.append(arms.touching_table())
    return np.array(seen)


@pytest.fixture
def arms():
    with closing(Arms(len(EVERYONE))) as arms:
        yield arms


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


def test_a_racket_driven_into_the_table_touches_it_until_it_is_put_back(arms):
    touching = down(arms)
    assert not touching[: 10 * STEPS_A_COMMAND].any() and touching[-1].all()
    assert (racket(arms.joints, arms.joint_speeds).position[:, 2] > -0.01).all()
    arms.reset(np.array([True, False, False, False]))
    assert arms.touching_table().tolist() == [False, True, True, True]
    arms.step()
    assert not arms.touching_table()[0]


def test_a_world_used_before_gives_the_same_bytes_as_a_fresh_one(arms):
    first = play(arms, *moves(4))
    down(arms)
    arms.reset(EVERYONE)
    assert play(arms, *moves(4)).tobytes() == first.tobytes()
    with closing(Arms(4)) as fresh:
        assert play(fresh, *moves(4)).tobytes() == first.tobytes()


def test_an_arm_s_path_depends_neither_on_its_row_nor_on_the_others(arms):
    velocities, turns = moves(4)
    together = play(arms, velocities, turns)
    with closing(Arms(1)) as alone:
        single = play(alone, velocities[:, [3]], turns[:, [3]])
    assert single[:, 0].tobytes() == together[:, 3].tobytes()
    arms.reset(EVERYONE)
    play(arms, velocities[:9], turns[:9])
    arms.reset(np.array([False, True, False, False]))
    np.testing.assert_array_equal(arms.joints[1], NEUTRAL)
    rest = play(arms, velocities[9:], turns[9:])
    np.testing.assert_array_equal(rest[:, [0, 2, 3]], together[45:, [0, 2, 3]])
