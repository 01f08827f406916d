"""Scattered shots follow their law, and each bounce keeps its deviation."""

import numpy as np
import pytest

from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import physics_of
from experiments.exam.simulate.scattered_shots import scattered_shots
from rallygap.models.arena.bounce_scatter import BounceScatter
from tests.experiments.exam.example_trials import NO_SCATTER, NOMINAL, drawn

LAUNCHES = drawn(shots=400)
TIMES = LAUNCHES.durations[:, None] * np.linspace(0, 1, 50)
BALLS = (NOMINAL, IndependentBall(physics_of(NOMINAL)))


def shots(ball=NOMINAL, scatter=NO_SCATTER, seed=0):
    random = np.random.default_rng(seed)
    return scattered_shots(ball, NOMINAL, LAUNCHES.states, LAUNCHES.durations, scatter, random)


@pytest.mark.parametrize("ball", BALLS)
def test_shots_follow_their_law_but_for_bounces_that_deviate_by_the_stated_sizes(ball):
    flown = shots(ball).fly(LAUNCHES.states, TIMES).states
    assert np.abs(flown - ball.fly(LAUNCHES.states, TIMES).states)[..., :3].max() < 1e-7

    contacts = shots(ball, BounceScatter(restitution=0.01, friction=0.05)).contacts
    met = contacts.count > 0
    e = -contacts.after[met, 0, 5] / contacts.before[met, 0, 5]
    assert e.mean() == pytest.approx(0.93, abs=0.002)
    assert e.std() == pytest.approx(0.0093, rel=0.12)


def test_scatter_acts_from_the_first_bounce_on_and_on_its_own_launches_only():
    scattered = shots(scatter=BounceScatter(restitution=0.05, friction=0.0))
    plain = NOMINAL.fly(LAUNCHES.states, TIMES).states
    flown = scattered.fly(LAUNCHES.states, TIMES).states

    first = ~(scattered.contacts.time[:, :1] <= TIMES)

    assert np.abs(flown - plain)[first].max() < 1e-9
    assert np.abs(flown - plain)[~first].max() > 0.01
    with pytest.raises(ValueError, match="own launches"):
        scattered.fly(LAUNCHES.states + 1e-3, TIMES)
