"""The simulation: what ends an episode, and what it brings."""

import numpy as np
import pytest
from scipy.optimize import brentq

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy import batch_simulation
from rallygap.models.policy.outcome import judge
from rallygap.models.robot.control import joint_speeds
from tests.models.policy.simulations import (
    ARRIVAL,
    CENTRE,
    NORMAL,
    SIMULATOR,
    STILL,
    beside_centre,
    goals,
    passing,
    played,
    simulation_with,
)

ASIDE = beside_centre(across=0.3)
NEVER = (np.nan, np.nan)
AHEAD_AND_DOWN = np.array([[0.0, 1.0, -1.0, 0.0, 0.0]])


@pytest.mark.parametrize("speed", [5.0, 20.0])
def test_a_ball_that_meets_a_waiting_racket_is_struck_and_judged(speed):
    incoming = passing(beside_centre(0.03, 0.02), velocity=(0.4, -speed, 0.5), spin=(60, 20, 9))

    def ball(time):
        return SIMULATOR.fly(incoming.path[0, 0], [time]).states[:, 0]

    time = brentq(lambda at: (ball(at)[0, :3] - CENTRE) @ NORMAL - BALL_RADIUS, 0.0, ARRIVAL)
    after = SIMULATOR.strike(ball(time), NORMAL[None], np.zeros((1, 3)))

    ended = played(simulation_with(incoming))[0].ended

    assert ended.hit[0]
    assert ended.time[0] == pytest.approx(time, abs=1e-4)
    np.testing.assert_allclose(ended.after_racket, after, atol=0.02, rtol=0.01)
    assert ended.distance == pytest.approx(judge(SIMULATOR, after, goals()).distance, abs=0.05)


def test_the_back_of_the_racket_is_distinguished_and_rewarded_less():
    ended = played(simulation_with(passing(CENTRE, velocity=(0.0, 5.0, 0.0))))[0].ended
    assert ended.hit[0]
    assert ended.backhand[0] == 1
    assert ended.after_racket[0, 4] < 5.0


@pytest.mark.parametrize(
    ("incoming", "actions", "fault", "nearest", "reward"),
    [
        (passing(ASIDE), STILL, "missed", 0.3, -0.6),
        (passing(CENTRE, playable=(0.3, 0.6)), STILL, "before_bounce", np.inf, -1.0),
        (passing(CENTRE, playable=NEVER), STILL, "missed", np.inf, -1.0),
        (passing(ASIDE, playable=(0.0, 1.4)), AHEAD_AND_DOWN, "arm_on_table", 0.37, -1.0),
    ],
    ids=["passes", "too early", "never playable", "arm on the table"],
)
def test_an_episode_without_a_hit_ends_with_a_fault(incoming, actions, fault, nearest, reward):
    step, rewards = played(simulation_with(incoming), actions)
    effort = 0.002 * (actions**2).sum() * len(rewards)
    assert step.ended.fault[0] == fault and not step.ended.hit[0]
    assert step.ended.nearest[0] == pytest.approx(nearest, abs=0.003)
    assert rewards.sum() + effort == pytest.approx(reward, abs=0.006)
    assert np.isnan(step.ended.landing).all()


@pytest.mark.parametrize(("latency", "commands"), [(0.02, 1), (0.1, 5), (0.2, 10)])
def test_actions_reach_the_arm_after_the_latency(latency, commands, monkeypatch):
    sent = []

    def recorded(joints, velocity, turning):
        sent.append(velocity[0].tolist())
        return joint_speeds(joints, velocity, turning)

    def velocities(latency):
        simulation = simulation_with(passing(ASIDE), latency=latency)
        for _ in range(10):  # the next ball does not get these actions
            simulation.step(AHEAD_AND_DOWN)
        simulation.reset(np.ones(1, dtype=bool), passing(ASIDE), goals())
        sent.clear()
        for action in np.random.default_rng(1).uniform(-0.1, 0.1, (9, 1, 5)):
            simulation.step(action)
        return list(sent)

    monkeypatch.setattr(batch_simulation, "joint_speeds", recorded)
    expected = [[0.0, 0.0, 0.0]] * commands + velocities(0.0)
    assert velocities(latency) == expected[: len(sent)]
