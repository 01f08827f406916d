"""Arms in Bullet: limits hold, the table is felt, the same commands give the same bytes."""

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
    with Arms(len(EVERYONE)) as arms:
        yield arms


@pytest.mark.parametrize("towards", [-1, 1])
def test_a_joint_stops_at_its_end(towards):
    with Arms(len(JOINTS)) as arms:
        arms.command(towards * 100 * np.eye(len(JOINTS)))
        for _ in range(250):
            arms.step()
        end = np.diag(LOWER if towards < 0 else UPPER)
        np.testing.assert_allclose(np.diag(arms.joints), np.diag(end), atol=1e-3)


@pytest.mark.parametrize("joint", range(len(JOINTS)))
def test_a_joint_asked_for_too_much_goes_at_its_speed(arms, joint):
    arms.command(np.tile(100 * np.eye(len(JOINTS))[joint], (4, 1)))
    fastest = 0.0
    for _ in range(150):
        arms.step()
        fastest = max(fastest, arms.joint_speeds[0, joint])
    assert fastest == pytest.approx(SPEED[joint], rel=0.02)


@pytest.mark.parametrize("joint", [0, 1])
def test_a_gantry_s_drive_accelerates_what_it_carries_by_its_force(arms, joint):
    arms.command(np.tile(100 * np.eye(len(JOINTS))[joint], (4, 1)))
    steps = 0
    while arms.joint_speeds[0, joint] < 0.99 * SPEED[joint]:
        arms.step()
        steps += 1
    carried = sum(solid.mass for beyond in JOINTS[joint:] for solid in beyond.link)
    needed = carried * SPEED[joint] / JOINTS[joint].force
    # The arm swings back a little, so that not all of it is carried at once.
    assert 0.75 * needed < steps * BULLET_STEP < 1.1 * needed


def test_a_racket_driven_into_the_table_touches_it_and_stops(arms):
    touching = down(arms)
    assert not touching[: 10 * STEPS_A_COMMAND].any() and touching[-1].all()
    assert (racket(arms.joints, arms.joint_speeds).position[:, 2] > -0.01).all()


def test_an_arm_that_is_put_back_no_longer_touches(arms):
    down(arms)
    arms.reset(np.array([True, False, False, False]))
    assert arms.touching_table().tolist() == [False, True, True, True]
    arms.step()
    assert not arms.touching_table()[0]


def test_a_world_used_before_gives_the_same_bytes_as_a_fresh_one(arms):
    first = play(arms, *moves(4))
    down(arms)
    arms.reset(EVERYONE)
    assert play(arms, *moves(4)).tobytes() == first.tobytes()
    with Arms(4) as fresh:
        assert play(fresh, *moves(4)).tobytes() == first.tobytes()


def test_an_arm_s_path_depends_neither_on_its_row_nor_on_the_others(arms):
    velocities, turns = moves(4)
    together = play(arms, velocities, turns)
    for row in (0, 3):
        with Arms(1) as alone:
            single = play(alone, velocities[:, [row]], turns[:, [row]])
        assert single[:, 0].tobytes() == together[:, row].tobytes()


def test_putting_one_arm_back_leaves_the_others_alone(arms):
    velocities, turns = moves(4)
    undisturbed = play(arms, velocities, turns)
    arms.reset(EVERYONE)
    play(arms, velocities[:9], turns[:9])
    arms.reset(np.array([False, True, False, False]))
    np.testing.assert_array_equal(arms.joints[1], NEUTRAL)
    rest = play(arms, velocities[9:], turns[9:])
    np.testing.assert_array_equal(rest[:, [0, 2, 3]], undisturbed[45:, [0, 2, 3]])
