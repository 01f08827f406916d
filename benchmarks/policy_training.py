"""Learning to return balls beside Stable-Baselines3 as it comes (`make bench`).

As it comes: `SAC("MlpPolicy", environment)`, every hyperparameter untouched, one environment. Ours
are those of params.yaml. Task, balls, machine and core are the same. Seconds are the core's own, so
that other programs on the machine count as little as they can.
"""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from stable_baselines3 import SAC
from stable_baselines3.common.logger import Logger

from models.policy.batch_simulation import ACTIONS
from models.policy.environment import ReturnEnv, ReturnVecEnv
from models.policy.learning import LEARNER, REPLAY, learn_leg, spare_weights
from models.policy.task import Task
from pipeline.evaluation.costs import one_core
from pipeline.io.simulators import load_simulator
from pipeline.params import load_params

PARAMS = load_params(Path(__file__).parents[1] / "params.yaml")
GROUP = PARAMS.train_policy.groups["sim2sim"]
LEARNING, SEED = GROUP.learning, PARAMS.seed
TASK = Task(
    load_simulator(GROUP.simulators[0]), GROUP.horizons_ms[0], GROUP.goals, GROUP.observation
)
MEASURED = 1.0  # s, at least, of every measurement
REPEATS = 3  # of which the best counts


def single_environment() -> ReturnEnv:
    return ReturnEnv(TASK.simulator, TASK.practice, TASK.observation)


def learner_as_it_comes() -> SAC:
    return SAC("MlpPolicy", single_environment(), seed=SEED, device="cpu")


def rate(work: Callable[[], int]) -> float:
    """Best of the repeats: how much work a second of the core does, after a warm-up."""
    work()
    return max(_rate(work) for _ in range(REPEATS))


def _rate(work: Callable[[], int]) -> float:
    start, done = time.process_time(), 0
    while (passed := time.process_time() - start) < MEASURED:
        done += work()
    return done / passed


def tick_of_many(arms: int) -> Callable[[], int]:
    """One random action of every arm; new balls included."""
    environment = ReturnVecEnv(TASK.simulator, TASK.practice, TASK.observation, arms, SEED)
    environment.reset()
    random = np.random.default_rng(SEED)

    def tick() -> int:
        environment.step(random.uniform(-1, 1, (arms, ACTIONS)))
        return arms

    return tick


def tick_of_one() -> Callable[[], int]:
    """One random action in the environment that Stable-Baselines3 gets as it comes."""
    environment = single_environment()
    environment.reset(seed=SEED)
    random = np.random.default_rng(SEED)

    def tick() -> int:
        ended = environment.step(random.uniform(-1, 1, ACTIONS))[2]
        if ended:
            environment.reset()
        return 1

    return tick


def steps_of(learner: SAC) -> Callable[[], int]:
    """Gradient steps on what the learner has seen so far."""
    learner.set_logger(Logger(None, []))

    def steps() -> int:
        learner.train(20, learner.batch_size)
        return 20

    return steps


def our_learner() -> SAC:
    """A learner after a leg just long enough to have taken its first gradient steps."""
    short = {"legs": 1, "warm_up": 1000, "ticks": 1000 + 2 * LEARNING.arms}
    with tempfile.TemporaryDirectory() as folder:
        left = Path(folder)
        learn_leg(TASK, LEARNING.model_copy(update=short), SEED, 0, None, left)
        learner = SAC.load(left / LEARNER, device="cpu")
        learner.load_replay_buffer(left / REPLAY)
    learner.critic.register_forward_pre_hook(spare_weights)
    return learner


def their_learner() -> SAC:
    return learner_as_it_comes().learn(1000)


def main() -> None:
    """Print control ticks and gradient steps a second, and the ratio."""
    with one_core():
        ticks = {arms: rate(tick_of_many(arms)) for arms in (32, 64)}
        one = rate(tick_of_one())
        steps, plain = rate(steps_of(our_learner())), rate(steps_of(their_learner()))
    table = Table("on one core", "rallygap", "SB3 as it comes", "rallygap is")
    for arms, speed in ticks.items():
        name = f"control ticks/s, {arms} arms to 1"
        table.add_row(name, f"{speed:,.0f}", f"{one:,.0f}", f"{speed / one:.1f} x")
    table.add_row("gradient steps/s", f"{steps:,.0f}", f"{plain:,.0f}", f"{steps / plain:.1f} x")
    Console().print(table)


if __name__ == "__main__":
    main()
