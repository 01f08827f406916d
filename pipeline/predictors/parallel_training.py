"""Trains several networks in parallel, each in its own process; killed runs resume."""

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd
from filelock import FileLock
from joblib import Parallel, cpu_count, delayed
from numpy.typing import NDArray

from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.spread import Spread
from rallygap.models.predictors.spread_training import fit_spread
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.pipeline.predictors.trainer import StepReporter, train
from rallygap.pipeline.runtime.progress import WatchedBars
from rallygap.pipeline.tracking.live import LiveRun, live_run

Counts = NDArray[np.int64]


@dataclass(frozen=True)
class TrainingJob:
    """A network to be trained, its data, and a checkpoint folder of its own."""

    name: str
    network: ForecastNetwork
    data: WindowData
    folder: Path

    @property
    def steps(self) -> int:
        """Number of its optimizer steps."""
        settings = self.data.settings
        windows = self.data.train.episodes * settings.windows_per_episode
        return settings.epochs * -(-windows // settings.batch)


@dataclass(frozen=True)
class TrainingResult:
    """A trained network and its spread, its learning curve (one row per epoch) and seconds."""

    name: str
    network: ForecastNetwork
    spread: Spread
    curve: pd.DataFrame
    seconds: float


def train_networks(jobs: Sequence[TrainingJob]) -> list[TrainingResult]:
    """Train all networks, as many at a time as there are cores for their threads.

    A result depends on the network's data and seed alone, not on the number of cores, the other
    networks, or interruptions. The MLflow run that is open gets losses and learning rates.
    """
    settings = [job.data.settings for job in jobs]
    if any(of_job.devices > 1 for of_job in settings):
        workers = 1  # each device has its own process
    else:
        at_once = int(cpu_count()) // max(of_job.threads for of_job in settings)
        workers = max(1, min(at_once, len(jobs)))
    live = [live_run(job.name) for job in jobs]  # here, because runs are open in one thread alone
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "steps"
        done: Counts = np.memmap(path, dtype=np.int64, mode="w+", shape=(len(jobs),))
        with WatchedBars({job.name: job.steps for job in jobs}, done.tolist):
            results: list[TrainingResult] = Parallel(workers)(
                delayed(_train_job)(job, StepCount(path, number, os.getpid()), live[number])
                for number, job in enumerate(jobs)
            )
    return results


@dataclass(frozen=True)
class StepCount:
    """Publishes the steps that the ``number``th job has done, in a file shared with the parent."""

    path: Path
    number: int
    master: int

    def __call__(self, steps: int) -> None:
        """Publish the count; end this process if its parent was killed."""
        if self.master not in (os.getpid(), os.getppid()):
            os._exit(1)
        self._done[self.number] = steps

    @cached_property
    def _done(self) -> Counts:
        return np.memmap(self.path, dtype=np.int64, mode="r+")


def _train_job(job: TrainingJob, steps_done: StepCount, live: LiveRun | None) -> TrainingResult:
    # The lock waits for a worker of a killed run that has not noticed it yet.
    training = ForecastTraining(job.network, job.data.settings)
    with FileLock(job.folder / "lock"):
        train(training, job.data, job.folder, [StepReporter(steps_done)], live)
    spread = fit_spread(job.network, job.data.train, job.data.seed)
    curve = pd.DataFrame(training.curve)
    return TrainingResult(job.name, job.network, spread, curve, training.seconds)
