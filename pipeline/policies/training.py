"""Trains policies in parallel, one training iteration after the other, and tests them.

A training that was interrupted resumes after its last complete iteration.
"""

import hashlib
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from filelock import FileLock
from safetensors.numpy import load, save

from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import evaluation_stream, validation_stream
from rallygap.models.policy.scores import scores
from rallygap.models.policy.trial import TrialResult, play
from rallygap.pipeline.io.artifacts import read_json, replacing_folder, write_json
from rallygap.pipeline.policies.storage import WEIGHTS, TrainedPolicy
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.progress import progress
from rallygap.pipeline.tracking.live import LiveRun, live_run
from rallygap.pipeline.tracking.results import TrainedModel

VALIDATION_SHOTS = 100  # that a policy plays after every iteration
RECORD = "record.json"
RETURN = "return.npz"  # among trained policies: the motion of a test shot
TEST_TRIALS = "unseen.parquet"  # among trained policies: the tables of ``play_test_shots``


@dataclass(frozen=True)
class TrainingJob:
    """A policy to be trained, and the folder of its training."""

    description: TrainedPolicy
    folder: Path

    def iteration(self, number: int) -> Path:
        """The folder of an iteration's learner, policy and validation."""
        return self.folder / f"iteration_{number:04d}"

    @property
    def iterations(self) -> int:
        """Number of all iterations."""
        return self.description.learning.iterations

    @property
    def iterations_done(self) -> int:
        """Number of complete iterations."""
        return len(list(self.folder.glob(f"iteration_*/{RECORD}")))


@dataclass(frozen=True)
class TrainingResult:
    """A trained policy, its learning curve (a row per iteration), and its CPU time (s)."""

    description: TrainedPolicy
    policy: Policy
    curve: pd.DataFrame
    seconds: float


def train_policies(jobs: Sequence[TrainingJob]) -> list[TrainingResult]:
    """Train all policies, one iteration of each in turn, in parallel.

    Results depend on descriptions alone: not on the number of processes, nor on interruptions.
    The MLflow run that is open gets returns, losses and learning rates.
    """
    total = sum(job.iterations for job in jobs)
    done = sum(job.iterations_done for job in jobs)
    for _ in progress(_iterations(jobs), "policies", total, done):
        pass
    return [_result(job) for job in jobs]


def _iterations(jobs: Sequence[TrainingJob]) -> Iterator[None]:
    """Train all policies for one iteration after the other; yield after each of each policy."""
    for number in range(max(job.iterations for job in jobs)):
        waiting = [job for job in jobs if job.iterations_done == number < job.iterations]
        yield from parallel(
            [partial(learn, job, number, live_run(job.description.name)) for job in waiting]
        )


def play_test_shots(
    results: Sequence[TrainingResult], shots: int, record: int = 0
) -> list[TrialResult]:
    """Let every policy play test shots of its own simulator, in parallel.

    Args:
        results: the policies.
        shots: that each plays.
        record: how many shots of the first policy to record.

    Returns:
        Each policy's trials; their tables also have its labels and the number of the ``ball``.
    """
    recorded = [record, *[0] * (len(results) - 1)]
    tasks = [
        partial(_test, result, shots, count)
        for result, count in zip(results, recorded, strict=True)
    ]
    return list(parallel(tasks))


def learn(job: TrainingJob, iteration: int, live: LiveRun | None = None) -> None:
    """Train a policy for one iteration; its folder appears whole or not at all.

    A worker of a killed run may still be at this iteration: wait for it, and keep its result.
    The MLflow run ``live`` gets metrics while the policy learns.
    """
    with FileLock(job.folder / "lock"):
        if job.iterations_done == iteration:
            before = job.iteration(iteration - 1) if iteration else None
            _train(job, iteration, before, live)
            if before is not None:  # but its record: learners are large
                for path in before.iterdir():
                    if path.name != RECORD:
                        path.unlink()


def _train(
    job: TrainingJob, iteration: int, before: Path | None, live: LiveRun | None = None
) -> None:
    from rallygap.models.policy.learning import learn_iteration  # takes seconds in every worker

    writers = []
    if live is not None:
        from rallygap.pipeline.tracking.sb3_writer import MlflowWriter

        writers.append(MlflowWriter(live))
    description = job.description
    task, learning, seed = description.task, description.learning, description.seed
    started = time.process_time()
    with replacing_folder(job.iteration(iteration)) as folder:
        policy = learn_iteration(task, learning, seed, iteration, before, folder, writers)
        seconds = time.process_time() - started
        (folder / WEIGHTS).write_bytes(save(policy.to_arrays()))
        played = _play(policy, description, VALIDATION_SHOTS, validation_stream(seed)).table
        steps = (iteration + 1) * learning.steps_per_iteration
        rates = {"hit_rate": played["hit"].mean(), "return_rate": played["returned"].mean()}
        write_json(folder / RECORD, {"seconds": seconds, "control_steps": steps, **rates})
    if live is not None:
        live.log(rates, steps)


def _test(result: TrainingResult, shots: int, record: int) -> TrialResult:
    stream = evaluation_stream(result.description.seed)
    played = _play(result.policy, result.description, shots, stream, record)
    labels = result.description.labels
    return replace(played, table=played.table.assign(**labels, ball=np.arange(shots)))


def _play(
    policy: Policy,
    description: TrainedPolicy,
    shots: int,
    stream: np.random.Generator,
    record: int = 0,
) -> TrialResult:
    task = description.task
    balls, goals = task.draw(shots, stream)
    return play(policy, task.simulator, balls, goals, task.observation, record)


def _result(job: TrainingJob) -> TrainingResult:
    last = job.iterations - 1
    records = [read_json(job.iteration(number) / RECORD) for number in range(last + 1)]
    policy = Policy.from_arrays(load((job.iteration(last) / WEIGHTS).read_bytes()))
    curve = pd.DataFrame(records)
    seconds = float(curve.pop("seconds").sum())
    return TrainingResult(job.description, policy, curve, seconds)


def policies_table(results: Sequence[TrainingResult], tests: Sequence[TrialResult]) -> pd.DataFrame:
    """Return one row a policy: its labels, how long it was trained, and its scores in a test."""
    rows = [
        {
            **result.description.labels,
            "control_steps": result.curve["control_steps"].iloc[-1],
            **scores(test.table),
        }
        for result, test in zip(results, tests, strict=True)
    ]
    return pd.DataFrame(rows)


def trained_models(
    results: Sequence[TrainingResult], tests: Sequence[TrialResult], folder: Path
) -> list[TrainedModel]:
    """Describe trained policies for MLflow, which compares their return rates on the same shots."""
    models = []
    for result, test in zip(results, tests, strict=True):
        description = result.description
        shots = description.model_dump_json(include={"effects", "horizons", "goals", "seed"})
        data = hashlib.md5(f"{len(test.table)} {shots}".encode()).hexdigest()
        name, rate = description.name, float(test.table["returned"].mean())
        models.append(
            TrainedModel(f"policy-{name}", folder / name, "return_rate", rate, False, data)
        )
    return models
