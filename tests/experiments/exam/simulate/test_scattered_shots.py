"""Shots whose bounces scatter, and causes that drift, differ from shot to shot or act in a half."""

import numpy as np
import pytest

from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import physics_of
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.scattered_shots import HalfRoom, scattered_shots
from experiments.exam.simulate.trial import Variation
from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NO_SCATTER, NOMINAL, drawn, ideal

LAUNCHES = drawn(shots=400)
TIMES = LAUNCHES.durations[:, None] * np.linspace(0, 1, 50)
BALLS = (NOMINAL, IndependentBall(physics_of(NOMINAL)))


def shots(ball=NOMINAL, scatter=NO_SCATTER):
    random = np.random.default_rng(0)
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


DRAG, WIND = Hypothesis("drag", "cd"), Hypothesis("wind", "x")
WINDY = NOMINAL.amended("wind", x=3.0)


def values(truth, parameter):
    return np.array([parameter.value(Simulator(part.effects)) for part in truth.parts])


def test_a_drift_starts_at_nominal_and_has_the_mean_of_the_cause():
    drift = Variation("drift", WIND)
    _, truth = simulate_trial(ideal(shots=11, causes={"wind": {"x": 0.5}}, variation=drift))
    assert values(truth, WIND) == pytest.approx(np.linspace(0.0, 1.0, 11))


def test_balls_differ_around_the_nominal_value_within_bounds():
    variation = Variation("shot", DRAG, spread=0.05)
    _, truth = simulate_trial(ideal(shots=200, causes={"drag": {"cd": 0.54}}, variation=variation))
    restitution = Variation("shot", Hypothesis("table_bounce", "restitution"), spread=0.08)

    assert values(truth, DRAG).mean() == pytest.approx(0.54, rel=0.02)
    assert values(truth, DRAG).std() == pytest.approx(0.05 * 0.54, rel=0.15)
    assert restitution.values(0.93, 0.93, 500, np.random.default_rng(0)).max() == 1.0


@pytest.mark.parametrize("dynamics", ["catalogue", "independent"])
def test_every_shot_follows_its_own_law_by_its_own_clock(dynamics):
    settings = {"shots": 5, "dynamics": dynamics, "seed": 3}
    drifting, truth = simulate_trial(
        ideal(causes={"wind": {"x": 2.0}}, variation=Variation("drift", WIND), **settings)
    )
    still, _ = simulate_trial(ideal(**settings))
    last = truth.states(drifting[4].times)[4, :, :3]
    assert drifting[4].positions == pytest.approx(last, abs=1e-9)
    apart = [np.abs(a.positions - b.positions).max() for a, b in zip(drifting, still, strict=True)]
    assert apart[0] < 1e-6
    assert apart[4] > apart[1] > 0.01

    clock, causes = Hypothesis("clock_rate", "d"), {"clock_rate": {"d": 0.01}}
    slowing, truth = simulate_trial(
        ideal(causes=causes, variation=Variation("drift", clock), **settings)
    )
    path = truth.states(slowing[4].times / 1.02)[4, :, :3]
    assert slowing[4].positions == pytest.approx(path, abs=1e-6)


def test_without_a_difference_half_rooms_are_the_whole_room():
    states, times = drawn(shots=40).states, np.linspace(0.0, 0.9, 60)
    found, whole = (one.fly(states, times) for one in (HalfRoom(NOMINAL, NOMINAL), NOMINAL))
    first = (slice(None), 0)
    until = np.nan_to_num(whole.contacts.time[:, 1], nan=9.0)[:, None]
    assert np.abs(found.states - whole.states)[times < until].max() < 1e-4
    for name, accuracy in (("time", 1e-6), ("after", 1e-3)):
        expected = getattr(whole.contacts, name)[first]
        met = getattr(found.contacts, name)[first]
        assert met == pytest.approx(expected, abs=accuracy, nan_ok=True)


def test_a_cause_acts_in_its_half_only():
    shots = drawn(shots=40)
    times = np.linspace(0.0, 0.3, 40)
    still, windy = (one.fly(shots.states, times).states for one in (NOMINAL, WINDY))
    found = HalfRoom(WINDY, NOMINAL).fly(shots.states, times).states

    starts_inside = shots.states[:, 1] > 0
    stays = (np.sign(still[..., 1]) == np.sign(still[:, :1, 1])).cumprod(axis=1).astype(bool)
    expected = np.where(starts_inside[:, None, None], windy, still)
    assert found[stays] == pytest.approx(expected[stays])
    crossed = ~stays[:, -1] & ~starts_inside
    moved = found[crossed, -1, 0] - still[crossed, -1, 0]
    whole = windy[crossed, -1, 0] - still[crossed, -1, 0]
    assert crossed.any() and (moved > 0).all() and (moved < whole).all()
