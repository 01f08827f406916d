"""The cannon: its balls land where they should, with the spin that was set."""

import numpy as np
import pytest

from rallygap.models.arena.cannon import cannon_launches, launch_states
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, VELOCITY
from tests.models.arena.sessions import TRUTH, of_group

SIMULATOR = TRUTH.simulator


@pytest.mark.parametrize("shots", [1, 500])
def test_nearly_every_ball_lands_on_the_near_half_first(shots):
    launches = cannon_launches(SIMULATOR, shots, np.random.default_rng(0))
    contacts = SIMULATOR.fly(launches, np.arange(0, 1.2, 0.005)).contacts
    on_near = (contacts.surface[:, 0] == TABLE) & (contacts.before[:, 0, 1] < 0)
    assert len(on_near) == shots
    assert on_near.mean() > 0.9


@pytest.mark.parametrize("yaw", [-90.0, 0.0, 30.0])
def test_a_launch_is_what_the_cannon_is_set_to(yaw):
    (state,) = launch_states(np.array([[0.1, 1.5, 0.3, yaw, 30.0, 6.0, 100.0, 20.0]]))
    along = np.array([np.sin(np.radians(yaw)), -np.cos(np.radians(yaw))])

    assert state[POSITION] == pytest.approx([0.1, 1.5, 0.3])
    assert state[VELOCITY] == pytest.approx([*(6 * np.sqrt(3) / 2 * along), 3])
    # Topspin turns the upper side of the ball ahead.
    upper_side = np.cross(state[SPIN], [0, 0, 1.0])
    assert upper_side == pytest.approx([*(100.0 * along), 0.0], abs=1e-9)
    assert state[8] == 20.0


def test_a_shot_is_seen_from_its_launch_until_shortly_after_its_second_contact():
    for shot in of_group("cannon"):
        contacts = shot.contacts
        assert contacts.kinds[0] == "launch"
        assert len(contacts.times) <= 3
        assert 0 <= shot.times[0] - contacts.times[0] < 0.0051
        assert shot.times[-1] > contacts.times[-1]


def test_a_simulator_in_which_no_ball_lands_is_an_error():
    weightless = Simulator.from_dict({"table_bounce": {"restitution": 0.9, "friction": 0.0}})
    lifted = weightless.amended("wind", z=10.0).amended("drag", cd=1.5)

    with pytest.raises(ValueError, match="hardly any shot"):
        cannon_launches(lifted, 5, np.random.default_rng(0))
