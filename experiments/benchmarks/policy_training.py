"""Speed of policy training, compared with Stable-Baselines3's defaults.

Defaults: `SAC("MlpPolicy", environment)` with one environment. rallygap: the settings of
params.yaml. Task, shots and machine are the same.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from stable_baselines3 import SAC
from stable_baselines3.common.logger import Logger

from experiments.benchmarks.comparison import ROOT, faster, one_core, rate, report
from rallygap.models.policy.batch_simulation import ACTIONS
from rallygap.models.policy.environment import ReturnVecEnv
from rallygap.models.policy.learning import LEARNER, REPLAY, learn_iteration, skip_critic_gradients
from rallygap.models.policy.task import Task
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import load_params

PARAMS = load_params(ROOT / "params.yaml")
GROUP = PARAMS.train_policy.groups["sim2sim"]
LEARNING, SEED = GROUP.learning, PARAMS.seed
TASK = Task(
    load_simulator(GROUP.simulators[0]), GROUP.horizons_ms[0], GROUP.goals, GROUP.observation
)
PEER = "SB3 defaults"


def default_learner(seed: int = SEED) -> SAC:
    """Return Stable-Baselines3's learner with its defaults."""
    return SAC("MlpPolicy", ReturnVecEnv(TASK, 1, seed), seed=seed, device="cpu")


def random_actions(arms: int) -> Callable[[], int]:
    """Return a control step with random actions of all arms in one simulation, with resets."""
    environment = ReturnVecEnv(TASK, arms, SEED)
    environment.reset()
    random = np.random.default_rng(SEED)

    def step() -> int:
        environment.step(random.uniform(-1, 1, (arms, ACTIONS)))
        return arms

    return step


def steps_of(learner: SAC) -> Callable[[], int]:
    """Return gradient steps of a learner on its replay buffer."""
    learner.set_logger(Logger(None, []))

    def steps() -> int:
        learner.train(20, learner.batch_size)
        return 20

    return steps


def our_learner() -> SAC:
    """Return a learner after an iteration just long enough for its first gradient steps."""
    short = {
        "iterations": 1,
        "warm_up": 1000,
        "steps_per_iteration": 1000 + 2 * LEARNING.environments,
    }
    with tempfile.TemporaryDirectory() as folder:
        left = Path(folder)
        learn_iteration(TASK, LEARNING.model_copy(update=short), SEED, 0, None, left)
        learner = SAC.load(left / LEARNER, device="cpu")
        learner.load_replay_buffer(left / REPLAY)
    learner.critic.register_forward_pre_hook(skip_critic_gradients)
    return learner


def main() -> None:
    """Measure control steps and gradient steps per second."""
    with one_core():
        single, *many = (rate(random_actions(arms)) for arms in (1, 32, 64))
        steps = rate(steps_of(our_learner()))
        peer_steps = rate(steps_of(default_learner().learn(1000)))
    comparisons = [
        faster(f"control steps per second, {arms} arms", speed, f"{PEER}, one arm", single)
        for arms, speed in zip((32, 64), many, strict=True)
    ]
    gradient = faster("gradient steps per second", steps, PEER, peer_steps)
    report("policy_training", [*comparisons, gradient])


if __name__ == "__main__":
    main()
