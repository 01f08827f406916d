"""Training with Stable-Baselines3's soft actor-critic, one training iteration at a time.

An iteration depends only on the learner that the previous one saved, and on the seed: balls, arms
and random numbers start afresh. So a training resumed from a saved learner ends with the same
weights as an uninterrupted one.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import SAC
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import KVWriter, Logger
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.vec_env import VecEnv, VecMonitor
from stable_baselines3.sac.policies import Actor
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from rallygap.models.policy.environment import ReturnVecEnv
from rallygap.models.policy.goal_relabelling import RelabellingReplayBuffer
from rallygap.models.policy.observation import goal_slice
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import iteration_seed
from rallygap.models.policy.settings import LearningSettings
from rallygap.models.policy.task import Task

Actions = NDArray[np.float32]

LEARNER, REPLAY = "learner.zip", "replay.pkl"  # read by the next iteration alone
LOGGED_EVERY = 400  # episodes
MEMORY = 0.997  # share of the averaged actor that a control step of all environments keeps


class AverageActor(BaseCallback):
    """Averages the weights of an actor while it learns; the average acts better (Polyak 1992).

    Args:
        actor: that learns.
        warm_up: control steps before it does.
    """

    def __init__(self, actor: Actor, warm_up: int) -> None:
        super().__init__()
        self._actor, self._warm_up = actor, warm_up
        averaging = get_ema_multi_avg_fn(MEMORY)  # type: ignore[no-untyped-call]
        self._average = AveragedModel(actor, multi_avg_fn=averaging)

    @property
    def mean(self) -> Actor:
        """The average of all steps so far, of which older ones count less."""
        return cast(Actor, self._average.module)

    def _on_step(self) -> bool:
        if self.num_timesteps > self._warm_up:
            self._average.update_parameters(self._actor)
        return True


class WarmedUpSAC(SAC):
    """Stable-Baselines3's soft actor-critic whose rackets follow balls until it learns."""

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[Actions, Actions]:
        if self.num_timesteps >= learning_starts:
            return super()._sample_action(learning_starts, action_noise, n_envs)
        assert self.env is not None
        (follow,) = self.env.get_attr("following_actions", [0])
        actions: Actions = follow(self.action_space.np_random).astype(np.float32)
        return actions, actions


def learn_iteration(
    task: Task,
    settings: LearningSettings,
    seed: int,
    iteration: int,
    before: Path | None,
    after: Path,
    writers: Sequence[KVWriter] = (),
) -> Policy:
    """Train for one iteration, and return the mean of its actors as the policy.

    Args:
        task: what is learned.
        settings: how.
        seed: of the whole training.
        iteration: its number, from 0 on.
        before: folder of the previous iteration's learner; ``None`` for the first.
        after: folder for this iteration's learner.
        writers: of returns, losses and the learning rate, as Stable-Baselines3 names them.
    """
    torch.set_num_threads(1)  # policies are trained in parallel, one per core
    own_seed = iteration_seed(seed, iteration)
    torch.manual_seed(own_seed)  # the initial weights
    environment = VecMonitor(ReturnVecEnv(task, settings.environments, own_seed))
    if before is None:
        learner = _new(environment, task, settings)
    else:
        learner = WarmedUpSAC.load(before / LEARNER, environment, device="cpu")
        learner.load_replay_buffer(before / REPLAY)
    rate = learning_rate(settings, iteration)
    learner.learning_rate, learner.lr_schedule = rate, lambda _: rate
    learner.set_random_seed(own_seed)
    learner.set_logger(Logger(None, list(writers)))
    learner.critic.register_forward_pre_hook(skip_critic_gradients)
    average = AverageActor(learner.actor, settings.warm_up)
    learner.learn(settings.steps_per_iteration, average, LOGGED_EVERY, reset_num_timesteps=False)
    environment.close()
    learner.save(after / LEARNER, exclude=["lr_schedule"])
    learner.save_replay_buffer(after / REPLAY)
    return trained_policy(average.mean)


def learning_rate(settings: LearningSettings, iteration: int) -> float:
    """Return the learning rate of an iteration: it decays geometrically."""
    share = iteration / max(settings.iterations - 1, 1)
    decay = settings.final_learning_rate / settings.learning_rate
    return settings.learning_rate * decay**share


def trained_policy(actor: Actor) -> Policy:
    """Return what an actor does without exploration."""
    parts = [part for part in (*actor.latent_pi, actor.mu) if isinstance(part, nn.Linear)]
    pairs = [(part.weight.detach().numpy(), part.bias.detach().numpy()) for part in parts]
    return Policy(tuple((weight.copy(), bias.copy()) for weight, bias in pairs))


def skip_critic_gradients(critic: nn.Module, inputs: tuple[Tensor, Tensor]) -> None:
    """Before critics judge (observations, actions): no gradients of their weights for the actor.

    Where the action has a gradient, the actor is being trained. SAC would also compute the critics'
    gradients and discard them, which costs 5 % of a gradient step.
    """
    critic.requires_grad_(not inputs[1].requires_grad)


def _new(environment: VecEnv, task: Task, settings: LearningSettings) -> WarmedUpSAC:
    steps = settings.iterations * settings.steps_per_iteration
    return WarmedUpSAC(
        "MlpPolicy",
        environment,
        batch_size=settings.batch,
        buffer_size=steps + settings.environments,
        ent_coef=f"auto_{settings.entropy}",
        gamma=settings.discount,
        tau=settings.target_step,
        gradient_steps=settings.gradient_steps,
        learning_starts=settings.warm_up,
        replay_buffer_class=RelabellingReplayBuffer,
        replay_buffer_kwargs={
            "goals": task.goals,
            "weights": task.reward,
            "columns": goal_slice(len(task.horizons), task.goals.count),
        },
        policy_kwargs={"net_arch": [settings.width] * 2, "optimizer_kwargs": {"fused": True}},
        device="cpu",
    )
