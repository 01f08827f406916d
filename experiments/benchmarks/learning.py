"""CPU time of training to a 95 % return rate, compared with Stable-Baselines3's defaults.

Task, seeds and validation shots are the same; neither policy learns from these shots. Times are CPU
seconds of training on one core, without validation, means over the seeds. rallygap uses the
settings of params.yaml. The peer is stopped after ``PATIENCE`` times the seconds of rallygap.
"""

import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import typer

from experiments.benchmarks.comparison import Comparison, one_core, report
from experiments.benchmarks.policy_training import LEARNING, PEER, TASK, default_learner
from rallygap.models.policy.learning import learn_iteration, trained_policy
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import validation_stream
from rallygap.models.policy.trial import play

GOAL = 0.95  # return rate
SEEDS = (1, 2, 3)
SHOTS = 500  # for validation; the standard error of a rate of 95 % is 1 %
PATIENCE = 3.0  # times the seconds of rallygap


@dataclass(frozen=True)
class Progress:
    """A training so far: control steps, CPU seconds, and the return rate."""

    steps: int
    seconds: float
    return_rate: float


def rallygap_policies(folder: Path, seed: int) -> Iterator[Policy]:
    """Yield the policy after every iteration; the time includes its checkpoints."""
    before = None
    for iteration in range(LEARNING.iterations):
        after = folder / str(iteration)
        after.mkdir()
        yield learn_iteration(TASK, LEARNING, seed, iteration, before, after)
        before = after


def peer_policies(seed: int) -> Iterator[Policy]:
    """Yield the peer's policy after as many control steps as an iteration has, without end."""
    learner = default_learner(seed)
    while True:
        learner.learn(LEARNING.steps_per_iteration, reset_num_timesteps=False)
        yield trained_policy(learner.actor)


def train(name: str, policies: Iterator[Policy], patience: float, seed: int) -> Progress:
    """Train to the goal, or until the policies or the seconds end; print every iteration."""
    steps, seconds, rate = 0, 0.0, 0.0
    while seconds < patience and rate < GOAL:
        start = time.process_time()
        policy = next(policies, None)
        if policy is None:
            break
        seconds += time.process_time() - start
        steps, rate = steps + LEARNING.steps_per_iteration, return_rate(policy, seed)
        typer.echo(f"{name}, seed {seed}: {steps:,} steps, {seconds:,.0f} s, {rate:.1%}")
    return Progress(steps, seconds, rate)


def return_rate(policy: Policy, seed: int) -> float:
    """Return the return rate of a policy on the validation shots of a seed."""
    shots = TASK.draw(SHOTS, validation_stream(seed))
    return float(play(policy, TASK.simulator, *shots, TASK.observation).table["returned"].mean())


def compared(ours: Sequence[Progress], peer: Sequence[Progress]) -> list[Comparison]:
    """Compare steps and seconds; the ratio to a peer that missed the goal is a lower bound."""
    reached = all(training.return_rate >= GOAL for training in ours)
    bound = any(training.return_rate < GOAL for training in peer)
    comparisons = []
    for measure, name in (("control steps", "steps"), ("CPU seconds", "seconds")):
        value, theirs = (float(np.mean([getattr(t, name) for t in of])) for of in (ours, peer))
        ratio = theirs / value if reached else None
        title = f"{measure} to a return rate of {GOAL:.0%}"
        comparisons.append(Comparison(title, value, PEER, theirs, ratio, bound))
    return comparisons


def main() -> None:
    """Train both with every seed, and compare."""
    ours, peer = [], []
    for seed in SEEDS:
        with one_core(), tempfile.TemporaryDirectory() as folder:
            policies = rallygap_policies(Path(folder), seed)
            ours.append(train("rallygap", policies, math.inf, seed))
            patience = PATIENCE * ours[-1].seconds
            peer.append(train(PEER, peer_policies(seed), patience, seed))
    report(
        "learning",
        compared(ours, peer),
        return_rates=[training.return_rate for training in ours],
        return_rates_of_peer=[training.return_rate for training in peer],
    )


if __name__ == "__main__":
    main()
