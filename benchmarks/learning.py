"""CPU time of training to a 90 % return rate, compared with Stable-Baselines3's defaults.

Task, seed and validation shots are the same; neither policy learns from these shots. Times are CPU
seconds of training on one core, without validation. rallygap uses the settings of the profile
`policies`. The peer is stopped after ``PATIENCE`` times the seconds of rallygap.
"""

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import typer

from benchmarks.comparison import ROOT, Comparison, report
from benchmarks.policy_training import PEER, SEED, TASK, default_learner
from models.policy.learning import learn_iteration, trained_policy
from models.policy.policy import Policy
from models.policy.random_streams import validation_stream
from models.policy.trial import play
from pipeline.evaluation.costs import one_core
from pipeline.experiments.profiles import merged
from pipeline.params import check_params, read_yaml

PROFILE = ROOT / "profiles" / "policies.yaml"
PARAMS = check_params(merged(read_yaml(ROOT / "params.yaml"), read_yaml(PROFILE)), PROFILE)
LEARNING = PARAMS.train_policy.groups["sim2sim"].learning

GOAL = 0.90  # return rate
SHOTS = 500  # for validation; the standard error of a rate of 90 % is 1.3 %
PATIENCE = 3.0  # times the seconds of rallygap


@dataclass(frozen=True)
class Progress:
    """A training so far: control ticks, CPU seconds, and the return rate."""

    ticks: int
    seconds: float
    return_rate: float


def rallygap_policies(folder: Path) -> Iterator[Policy]:
    """Yield the policy after every iteration; the time includes its checkpoints."""
    before = None
    for iteration in range(LEARNING.iterations):
        after = folder / str(iteration)
        after.mkdir()
        yield learn_iteration(TASK, LEARNING, SEED, iteration, before, after)
        before = after


def peer_policies() -> Iterator[Policy]:
    """Yield the peer's policy after as many ticks as an iteration has, without end."""
    learner = default_learner()
    while True:
        learner.learn(LEARNING.steps_per_iteration, reset_num_timesteps=False)
        yield trained_policy(learner)


def train(name: str, policies: Iterator[Policy], patience: float) -> Progress:
    """Train to the goal, or until the policies or the seconds end; print every iteration."""
    ticks, seconds, rate = 0, 0.0, 0.0
    while seconds < patience and rate < GOAL:
        start = time.process_time()
        policy = next(policies, None)
        if policy is None:
            break
        seconds += time.process_time() - start
        ticks, rate = ticks + LEARNING.steps_per_iteration, return_rate(policy)
        typer.echo(f"{name}: {ticks:,} ticks, {seconds:,.0f} s, {rate:.1%}")
    return Progress(ticks, seconds, rate)


def return_rate(policy: Policy) -> float:
    """Return the return rate of a policy on the validation shots."""
    balls, goals = TASK.draw(SHOTS, validation_stream(SEED))
    return float(
        play(policy, TASK.simulator, balls, goals, TASK.observation).table["returned"].mean()
    )


def compared(ours: Progress, peer: Progress) -> list[Comparison]:
    """Compare ticks and seconds; the ratio to a peer that missed the goal is a lower bound."""
    reached, bound = ours.return_rate >= GOAL, peer.return_rate < GOAL
    pairs = {
        f"control ticks to a return rate of {GOAL:.0%}": (ours.ticks, peer.ticks),
        f"CPU seconds to a return rate of {GOAL:.0%}": (ours.seconds, peer.seconds),
    }
    return [
        Comparison(measure, value, PEER, theirs, theirs / value if reached else None, bound)
        for measure, (value, theirs) in pairs.items()
    ]


def main() -> None:
    """Train both and compare."""
    with one_core(), tempfile.TemporaryDirectory() as folder:
        ours = train("rallygap", rallygap_policies(Path(folder)), math.inf)
        peer = train(PEER, peer_policies(), PATIENCE * ours.seconds)
    report(
        "learning",
        compared(ours, peer),
        return_rate=ours.return_rate,
        return_rate_of_peer=peer.return_rate,
    )


if __name__ == "__main__":
    main()
