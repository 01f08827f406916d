"""Learning: Stable-Baselines3's soft actor-critic, one leg at a time.

A leg depends on nothing but the learner that the leg before left behind, and the seed: balls,
arms and random numbers begin anew. So a training that goes on from a learner on disk ends as if
nothing had happened.
"""

from pathlib import Path

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.logger import Logger
from torch import Tensor, nn

from models.policy.environment import ReturnVecEnv
from models.policy.goal_relabelling import RetoldReplay
from models.policy.observation import goal_columns
from models.policy.policy import Policy, Singles
from models.policy.random_streams import leg_seed
from models.policy.settings import LearningSettings
from models.policy.task import Task

LEARNER, REPLAY = "learner.zip", "replay.pkl"  # on disk, for nobody but the next leg


def learn_leg(
    task: Task, settings: LearningSettings, seed: int, leg: int, before: Path | None, after: Path
) -> Policy:
    """Go through one leg.

    Args:
        task: what is learned.
        settings: how.
        seed: of the whole training.
        leg: which, from 0 on.
        before: folder of the learner that the previous leg left; ``None`` for the first leg.
        after: folder for the learner that this leg leaves.

    Returns:
        The policy as it is after the leg.
    """
    torch.set_num_threads(1)  # policies are trained side by side, one a core
    own_seed = leg_seed(seed, leg)
    torch.manual_seed(own_seed)  # the first weights
    environment = ReturnVecEnv(
        task.simulator, task.practice, task.observation, settings.arms, own_seed
    )
    learner = _new(environment, task, settings) if before is None else _resumed(environment, before)
    rate = learning_rate(settings, leg)
    learner.learning_rate, learner.lr_schedule = rate, lambda _: rate
    learner.set_random_seed(own_seed)
    learner.set_logger(Logger(None, []))  # or every leg would leave a folder of logs
    learner.critic.register_forward_pre_hook(spare_weights)
    learner.learn(settings.ticks, reset_num_timesteps=False)
    environment.close()
    learner.save(after / LEARNER, exclude=["lr_schedule"])
    learner.save_replay_buffer(after / REPLAY)
    return trained_policy(learner)


def learning_rate(settings: LearningSettings, leg: int) -> float:
    """Return the learning rate of a leg."""
    share = leg / max(settings.legs - 1, 1)
    fall = settings.final_learning_rate / settings.learning_rate
    rate: float = settings.learning_rate * fall**share
    return rate


def trained_policy(learner: SAC) -> Policy:
    """Return the mean of a learner's actor."""
    actor = learner.policy.actor
    maps = [part for part in (*actor.latent_pi, actor.mu) if isinstance(part, nn.Linear)]
    return Policy(tuple((_array(part.weight), _array(part.bias)) for part in maps))


def spare_weights(critic: nn.Module, inputs: tuple[Tensor, Tensor]) -> None:
    """Before critics judge (observations, actions), let them learn only if the actor does not.

    Where an action has a gradient, it is the actor that learns. SAC would work out the gradients of
    the critics' weights, too, and throw them away: a twentieth of a gradient step.
    """
    critic.requires_grad_(not inputs[1].requires_grad)


def _new(environment: ReturnVecEnv, task: Task, settings: LearningSettings) -> SAC:
    return SAC(
        "MlpPolicy",
        environment,
        batch_size=settings.batch,
        buffer_size=settings.legs * settings.ticks + settings.arms,
        ent_coef=f"auto_{settings.entropy}",
        gamma=settings.discount,
        tau=settings.target_step,
        gradient_steps=settings.gradient_steps,
        learning_starts=settings.warm_up,
        replay_buffer_class=RetoldReplay,
        replay_buffer_kwargs={
            "goals": task.goals,
            "columns": goal_columns(len(task.horizons), task.goals.count),
        },
        policy_kwargs={"net_arch": [settings.width] * 2, "optimizer_kwargs": {"fused": True}},
        device="cpu",
    )


def _resumed(environment: ReturnVecEnv, before: Path) -> SAC:
    learner = SAC.load(before / LEARNER, environment, device="cpu")
    learner.load_replay_buffer(before / REPLAY)
    return learner


def _array(parameter: Tensor) -> Singles:
    array: Singles = parameter.detach().numpy().copy()
    return array
