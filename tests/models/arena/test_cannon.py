"""The cannon: its balls land where they should, with the spin that was set."""

import numpy as np
import pytest

from models.arena.cannon import MUZZLE, cannon_launches, launch_states
from models.ball.contact import TABLE
from models.ball.simulator import Simulator
from models.ball.simulators import shipped
from models.ball.state import POSITION, SPIN, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH, VELOCITY

SIMULATOR = shipped("ground_truth")


def launches(shots, seed=0):
    return cannon_launches(SIMULATOR, shots, np.random.default_rng(seed))


@pytest.mark.parametrize("shots", [1, 60, 500])
def test_every_ball_flies_over_the_net_and_lands_on_the_near_half(shots):
    contacts = SIMULATOR.fly(launches(shots), np.arange(0, 1.2, 0.005)).contacts

    landing = contacts.before[:, 0, POSITION]
    assert len(landing) == shots
    assert (contacts.surface[:, 0] == TABLE).all()
    assert (np.abs(landing[:, 0]) < TABLE_HALF_WIDTH + 0.02).all()
    assert ((landing[:, 1] < 0) & (landing[:, 1] > -TABLE_HALF_LENGTH - 0.02)).all()


def test_a_session_spreads_over_directions_speeds_and_spins():
    states = launches(60)

    yaw = np.degrees(np.arctan2(states[:, 3], -states[:, 4]))
    assert yaw.min() < -6
    assert yaw.max() > 6
    assert np.ptp(np.linalg.norm(states[:, VELOCITY], axis=1)) > 2
    assert states[:, 6].min() < -150  # backspin
    assert states[:, 6].max() > 150  # topspin
    assert np.ptp(states[:, 8]) > 250  # sidespin


def test_the_same_seed_gives_the_same_session():
    assert np.array_equal(launches(30), launches(30))
    assert not np.array_equal(launches(30), launches(30, seed=1))


def test_a_launch_is_what_the_cannon_is_set_to():
    (state,) = launch_states(np.array([[0.0, 30.0, 6.0, 100.0, 20.0]]))

    assert state[POSITION].tolist() == list(MUZZLE)
    assert state[VELOCITY] == pytest.approx([0, -6 * np.sqrt(3) / 2, 3])
    assert state[SPIN] == pytest.approx([100, 0, 20])


@pytest.mark.parametrize("yaw", [-90.0, 0.0, 30.0])
def test_topspin_turns_the_upper_side_of_the_ball_ahead(yaw):
    (state,) = launch_states(np.array([[yaw, 0.0, 6.0, 100.0, 0.0]]))

    upper_side = np.cross(state[SPIN], [0, 0, 0.02])
    assert upper_side == pytest.approx(2.0 * state[VELOCITY] / 6.0, abs=1e-12)


def test_a_simulator_in_which_no_ball_lands_is_an_error():
    weightless = Simulator.from_dict({"table_bounce": {"restitution": 0.9, "friction": 0.25}})

    with pytest.raises(ValueError, match="hardly any shot"):
        cannon_launches(weightless, 5, np.random.default_rng(0))
