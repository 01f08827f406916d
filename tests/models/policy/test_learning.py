"""Learning in iterations: the learner before and the seed decide, and nothing else."""

import io

import numpy as np
import pytest
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.logger import HumanOutputFormat, Logger

from rallygap.models.policy.learning import (
    LEARNER,
    MEMORY,
    AverageActor,
    learn_iteration,
    skip_critic_gradients,
    trained_policy,
)
from rallygap.models.policy.observation import LIMIT
from tests.models.policy.schooling import BRIEF, TASK, same


def iteration(after, number=0, before=None, seed=3):
    after.mkdir()
    return learn_iteration(TASK, BRIEF, seed, number, before, after)


@pytest.fixture(scope="module")
def schooled(tmp_path_factory):
    """The folder of a learner after the first iteration, and its policy; not to be changed."""
    folder = tmp_path_factory.mktemp("schooled") / "iteration"
    return folder, iteration(folder)


def test_writers_get_returns_losses_and_the_rate(tmp_path, monkeypatch):
    monkeypatch.setattr("rallygap.models.policy.learning.LOGGED_EVERY", 1)
    long, written = BRIEF.model_copy(update={"steps_per_iteration": 160}), io.StringIO()
    learn_iteration(TASK, long, 3, 0, None, tmp_path, [HumanOutputFormat(written)])
    for name in ("ep_rew_mean", "critic_loss", "learning_rate"):
        assert name in written.getvalue()


def test_an_iteration_continues_from_the_whole_replay_buffer_at_its_own_rate(schooled, tmp_path):
    assert not same(iteration(tmp_path / "second", 1, schooled[0]), schooled[1])
    learner = SAC.load(tmp_path / "second" / LEARNER)
    learner.load_replay_buffer(tmp_path / "second" / "replay.pkl")
    assert learner.num_timesteps == 2 * BRIEF.steps_per_iteration
    assert BRIEF.environments * learner.replay_buffer.size() == 2 * BRIEF.steps_per_iteration
    steps = (2 * BRIEF.steps_per_iteration - BRIEF.warm_up) // BRIEF.environments
    updates = steps * BRIEF.gradient_steps
    assert learner._n_updates == pytest.approx(updates, abs=BRIEF.gradient_steps)
    optimizers = learner.actor.optimizer, learner.critic.optimizer, learner.ent_coef_optimizer
    rates = [optimizer.param_groups[0]["lr"] for optimizer in optimizers]
    assert rates == pytest.approx([0.001] * 3)


def test_sparing_the_critics_changes_nothing_of_what_is_learned(schooled):
    plain, spared = (SAC.load(schooled[0] / LEARNER) for _ in range(2))
    spared.critic.register_forward_pre_hook(skip_critic_gradients)
    for learner in (plain, spared):
        learner.load_replay_buffer(schooled[0] / "replay.pkl")
        learner.set_logger(Logger(None, []))
        learner.set_random_seed(5)
        learner.train(3, BRIEF.batch)
    pairs = zip(
        plain.policy.state_dict().values(), spared.policy.state_dict().values(), strict=True
    )
    assert all(torch.equal(*pair) for pair in pairs)
    before = SAC.load(schooled[0] / LEARNER)
    assert not same(trained_policy(plain.actor), trained_policy(before.actor))


def test_the_policy_acts_as_its_actor_without_noise(schooled):
    learner = SAC.load(schooled[0] / LEARNER)
    size = learner.observation_space.shape[0]
    seen = np.random.default_rng(1).uniform(-LIMIT, LIMIT, (100, size)).astype(np.float32)
    expected, _ = learner.predict(seen, deterministic=True)
    np.testing.assert_allclose(trained_policy(learner.actor).act(seen), expected, atol=1e-6)


def test_in_the_average_older_actors_count_less(schooled):
    """The closed form of the average after four steps, of which one is of the warm-up."""
    actor = SAC.load(schooled[0] / LEARNER).actor
    start = [one.detach().clone() for one in actor.parameters()]
    average = AverageActor(actor, warm_up=5)
    for step in range(4):
        average.num_timesteps = 5 + step
        with torch.no_grad():
            for one, first in zip(actor.parameters(), start, strict=True):
                one.copy_(first + step)
        assert average._on_step()
    weights = (MEMORY**2, MEMORY * (1 - MEMORY), 1 - MEMORY)  # of the steps after the warm-up
    shift = sum(weight * step for weight, step in zip(weights, (1, 2, 3), strict=True))
    for one, first in zip(average.mean.parameters(), start, strict=True):
        torch.testing.assert_close(one, first + shift)


def test_an_iteration_returns_the_mean_of_its_actors(schooled, tmp_path, monkeypatch):
    monkeypatch.setattr("rallygap.models.policy.learning.MEMORY", 0)  # the mean is the latest actor
    latest = iteration(tmp_path / "latest")
    folders = schooled[0], tmp_path / "latest"
    learned = [trained_policy(SAC.load(folder / LEARNER).actor) for folder in folders]
    assert same(*learned)  # what is averaged does not change what is learned
    assert not same(iteration(tmp_path / "other", seed=4), latest)
    assert not same(latest, schooled[1])
    assert not same(learned[0], schooled[1])
