"""The outcome of a stroke, against closed forms and the roll-out's own contacts."""

import numpy as np
import pytest

from rallygap.models.ball.contact_laws import NET, TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge, topspin, with_net

AIRLESS = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.25}}
)
HAND = np.array([0.2, -1.6, 0.3])


def struck(*velocities, spin=(0.0, 0.0, 0.0)):
    return np.array([np.concatenate([HAND, velocity, spin]) for velocity in velocities])


def judged(states, landing=(0.0, 0.8)):
    return judge(AIRLESS, states, Goals(np.tile(landing, (len(states), 1))))


def parabola(velocity):
    """Where a ball from ``HAND`` comes down, and how high it passes the net's line, by hand."""
    vx, vy, vz = velocity
    time = (vz + np.sqrt(vz**2 + 2 * 9.81 * (HAND[2] - BALL_RADIUS))) / 9.81
    passing = -HAND[1] / vy
    height = HAND[2] + vz * passing - 9.81 / 2 * passing**2
    return HAND[:2] + np.array([vx, vy]) * time, height


@pytest.mark.parametrize(
    ("velocity", "fault"),
    [
        ((-0.2, 4.0, 2.6), ""),
        ((0.5, 6.0, 1.2), ""),
        ((0.0, 7.0, 3.0), "out"),
        ((3.0, 4.0, 2.6), "out"),
        ((0.0, 7.0, 0.2), "net"),
        ((0.0, 2.0, 2.0), "out"),  # its own half
    ],
)
def test_a_ball_lands_where_its_parabola_ends(velocity, fault):
    landing, height = parabola(velocity)
    outcome = judged(struck(velocity))
    assert outcome.fault[0] == fault
    assert outcome.returned[0] == (fault == "")
    np.testing.assert_allclose(outcome.landing[0], landing, atol=2e-3 if fault else 1e-9)
    expected = np.nan if fault else [*landing, BALL_RADIUS, *velocity[:2]]
    np.testing.assert_allclose(outcome.before_landing[0, :5], expected)
    assert outcome.net_height[0] == pytest.approx(height, abs=2e-4)
    assert outcome.distance[0] == pytest.approx(np.hypot(*(landing - [0.0, 0.8])), abs=2e-3)


def test_a_ball_over_the_net_cord_is_returned():
    rises = np.linspace(0.7, 1.0, 61)
    balls = struck(*[(0.0, 6.0, rise) for rise in rises])
    met = with_net(AIRLESS).fly(balls, [2.5]).contacts
    grazed = (met.surface[:, 0] == NET) & (met.surface[:, 1] == TABLE)
    over, back = grazed & (met.before[:, 1, 1] > 0), grazed & (met.before[:, 1, 1] < 0)
    outcome = judged(balls)
    assert over.any()
    assert outcome.returned[over].all()
    np.testing.assert_array_equal(outcome.landing[over], met.before[over, 1, :2])
    assert back.any()
    assert (outcome.fault[back] == "net").all()


def test_a_ball_struck_backwards_or_below_the_table_is_not_returned():
    balls = struck((0.0, -2.0, 1.0), (0.0, 5.0, 1.0))
    balls[1, 2] = -0.3
    outcome = judged(balls)
    assert not outcome.returned.any()
    np.testing.assert_allclose(outcome.landing[0], parabola((0.0, -2.0, 1.0))[0], atol=2e-3)
    assert outcome.net_height[0] < -10


@pytest.mark.parametrize("way", [(0.0, 5.0), (3.0, 4.0), (-2.0, 1.0), (0.0, -5.0)])
def test_topspin_turns_the_upper_side_ahead(way):
    ahead = np.array([*way, 0.0]) / np.hypot(*way)
    upper = np.array([0.0, 0.0, BALL_RADIUS])
    spin = np.array([12.0, -30.0, 44.0])
    state = np.concatenate([HAND, [*way, 1.0], spin])
    assert topspin(state[None])[0] == pytest.approx(np.cross(spin, upper) @ ahead / BALL_RADIUS)
