"""Time to 90 % returns beside Stable-Baselines3 as it comes (the last part of `make bench`).

Task and seed are the same, and so are the balls on which both are watched: neither learns on them.
Looking costs nothing: the seconds are those of learning alone, of one core. Our policy learns with
the settings of the profile `policies`. Its peer is given several times the seconds that ours took;
who is not there by the end is reported with what it reached.
"""

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.policy_training import SEED, TASK, learner_as_it_comes
from models.policy.learning import learn_leg, trained_policy
from models.policy.policy import Policy
from models.policy.random_streams import watched_balls
from models.policy.trial import play
from pipeline.evaluation.costs import one_core
from pipeline.experiments.profiles import merged
from pipeline.params import check_params, read_yaml

ROOT = Path(__file__).parents[1]
PROFILE = ROOT / "profiles" / "policies.yaml"
PARAMS = check_params(merged(read_yaml(ROOT / "params.yaml"), read_yaml(PROFILE)), PROFILE)
LEARNING = PARAMS.train_policy.groups["sim2sim"].learning

GOAL = 0.90  # of the balls returned
BALLS = 500  # watched; by their luck a rate of 90 % is off by 1.3 % (standard deviation)
PATIENCE = 3.0  # times our seconds that the peer is given


@dataclass(frozen=True)
class Mark:
    """How far somebody has come: ticks and seconds of learning, share of balls returned."""

    ticks: int
    seconds: float
    returned: float


def ours(folder: Path) -> Iterator[Policy]:
    """Yield the policy after every leg; what legs cost on disk is part of it."""
    before = None
    for leg in range(LEARNING.legs):
        after = folder / str(leg)
        after.mkdir()
        yield learn_leg(TASK, LEARNING, SEED, leg, before, after)
        before = after


def theirs() -> Iterator[Policy]:
    """Yield the policy after as many ticks, on and on."""
    learner = learner_as_it_comes()
    while True:
        learner.learn(LEARNING.ticks, reset_num_timesteps=False)
        yield trained_policy(learner)


def marks(policies: Iterator[Policy], patience: float) -> Iterator[Mark]:
    """Yield how far somebody has come, until it returns enough or its seconds are spent."""
    ticks, seconds, returned = 0, 0.0, 0.0
    while seconds < patience and returned < GOAL:
        start = time.process_time()
        policy = next(policies, None)
        if policy is None:
            return
        seconds += time.process_time() - start
        ticks, returned = ticks + LEARNING.ticks, return_rate(policy)
        yield Mark(ticks, seconds, returned)


def return_rate(policy: Policy) -> float:
    balls, goals = TASK.practice(BALLS, watched_balls(SEED))
    return float(play(policy, TASK.simulator, balls, goals, TASK.observation)["returned"].mean())


def last(name: str, policies: Iterator[Policy], patience: float, console: Console) -> Mark:
    """Print every mark; return the last."""
    for mark in marks(policies, patience):
        console.print(f"{name}: {mark.ticks:,} ticks, {mark.seconds:,.0f} s, {mark.returned:.1%}")
    return mark


def result(our: Mark, their: Mark) -> Table:
    """Return both last marks side by side; a ratio to somebody who never got there is a bound."""
    table = Table(f"to {GOAL:.0%} returns, one core", "rallygap", "SB3 as it comes", "rallygap is")
    bound = "" if their.returned >= GOAL else "more than "
    for name in ("ticks", "seconds"):
        taken, theirs_taken = getattr(our, name), getattr(their, name)
        ratio = f"{bound}{theirs_taken / taken:.1f} x" if our.returned >= GOAL else "not there"
        table.add_row(name, f"{taken:,.0f}", f"{theirs_taken:,.0f}", ratio)
    table.add_row("returned by then", f"{our.returned:.1%}", f"{their.returned:.1%}", "")
    return table


def main() -> None:
    """Print both courses, then the table."""
    console = Console()
    with one_core(), tempfile.TemporaryDirectory() as folder:
        our = last("rallygap", ours(Path(folder)), math.inf, console)
        their = last("SB3 as it comes", theirs(), PATIENCE * our.seconds, console)
    console.print(result(our, their))


if __name__ == "__main__":
    main()
