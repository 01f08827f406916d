"""Trains policies side by side, leg by leg, so that a killed run goes on where it was."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from filelock import FileLock
from safetensors.numpy import load, save

from models.policy.policy import Policy
from models.policy.random_streams import unseen_balls, watched_balls
from models.policy.trial import play
from pipeline.io.artifacts import read_json, replacing_folder, write_json
from pipeline.policies.storage import WEIGHTS, TrainedPolicy
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar

TRIALS = 100  # balls on which a policy is watched after every leg
RECORD = "record.json"
UNSEEN = "unseen.parquet"  # among trained policies: how the balls of ``try_policies`` ended


@dataclass(frozen=True)
class Pupil:
    """A policy to be trained, and a folder that belongs to its training alone."""

    description: TrainedPolicy
    folder: Path

    def leg(self, number: int) -> Path:
        """The folder of what a leg leaves: the learner, the policy and how well it plays."""
        return self.folder / f"leg_{number:04d}"

    @property
    def legs_done(self) -> int:
        """How many legs are behind it."""
        return len(list(self.folder.glob(f"leg_*/{RECORD}")))


@dataclass(frozen=True)
class Graduate:
    """A trained policy, its learning curve (a record a leg), and CPU seconds it took."""

    description: TrainedPolicy
    policy: Policy
    curve: pd.DataFrame
    seconds: float


def train_policies(pupils: Sequence[Pupil]) -> list[Graduate]:
    """Train every pupil to the end; one leg of each in turn, side by side.

    What a leg leaves depends on the leg before and the seed alone, not on where and how many
    run at once, nor on kills in between.
    """
    legs = max(pupil.description.learning.legs for pupil in pupils)
    whole = sum(pupil.description.learning.legs for pupil in pupils)
    done = sum(pupil.legs_done for pupil in pupils)
    with progress_bar("policies", whole, done) as advance:
        for leg in range(legs):
            waiting = [
                pupil
                for pupil in pupils
                if pupil.legs_done == leg < pupil.description.learning.legs
            ]
            for _ in parallel([partial(learn, pupil, leg) for pupil in waiting]):
                advance()
    return [_graduate(pupil) for pupil in pupils]


def try_policies(graduates: Sequence[Graduate], trials: int) -> list[pd.DataFrame]:
    """Let every policy play balls of its own simulator that it has never seen, side by side.

    Returns:
        Of each policy how ``trials`` balls ended: its labels, the ``ball``'s number, and what
        ``play`` returns.
    """
    return list(parallel([partial(_played_unseen, one, trials) for one in graduates]))


def learn(pupil: Pupil, leg: int) -> None:
    """Take a pupil through a leg; what it leaves appears whole or not at all.

    A worker of a run that was killed may still be at this leg: wait, and keep what it leaves.
    """
    with FileLock(pupil.folder / "lock"):
        if pupil.legs_done == leg:
            before = pupil.leg(leg - 1) if leg else None
            _learn_on(pupil, leg, before)
            if before is not None:
                _forget_learner(before)


def _learn_on(pupil: Pupil, leg: int, before: Path | None) -> None:
    from models.policy.learning import learn_leg  # takes seconds; workers alone need it

    description = pupil.description
    started = time.process_time()
    with replacing_folder(pupil.leg(leg)) as folder:
        policy = learn_leg(
            description.task, description.learning, description.seed, leg, before, folder
        )
        seconds = time.process_time() - started
        (folder / WEIGHTS).write_bytes(save(policy.to_arrays()))
        record = _watched(policy, description, leg)
        write_json(folder / RECORD, {"seconds": seconds, **record})


def _watched(policy: Policy, description: TrainedPolicy, leg: int) -> dict[str, Any]:
    played = _played(policy, description, TRIALS, watched_balls(description.seed))
    return {
        "ticks": (leg + 1) * description.learning.ticks,
        "hit_rate": played["hit"].mean(),
        "return_rate": played["returned"].mean(),
    }


def _played(
    policy: Policy, description: TrainedPolicy, count: int, source: np.random.Generator
) -> pd.DataFrame:
    task = description.task
    balls, goals = task.practice(count, source)
    return play(policy, task.simulator, balls, goals, task.observation)


def _played_unseen(one: Graduate, count: int) -> pd.DataFrame:
    played = _played(one.policy, one.description, count, unseen_balls(one.description.seed))
    return played.assign(**one.description.labels, ball=np.arange(count))


def _forget_learner(folder: Path) -> None:
    """Keep of a leg that another has followed the record alone: learners are large."""
    for path in folder.iterdir():
        if path.name != RECORD:
            path.unlink()


def _graduate(pupil: Pupil) -> Graduate:
    last = pupil.description.learning.legs - 1
    records = [read_json(pupil.leg(number) / RECORD) for number in range(last + 1)]
    policy = Policy.from_arrays(load((pupil.leg(last) / WEIGHTS).read_bytes()))
    curve = pd.DataFrame(records)
    seconds = float(curve.pop("seconds").sum())
    return Graduate(pupil.description, policy, curve, seconds)
