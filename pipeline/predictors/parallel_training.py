"""Trains networks side by side, each in a process of its own, so that a killed run goes on."""

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from filelock import FileLock
from joblib import Parallel, cpu_count, delayed
from numpy.typing import NDArray

from models.predictors.learned import ForecastNetwork
from models.predictors.training import ForecastTraining, WindowData
from pipeline.predictors.trainer import Steps, train
from pipeline.runtime.progress import progress_bars

Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Pupil:
    """A network to be trained, on what, and a folder that belongs to its training alone."""

    name: str
    network: ForecastNetwork
    data: WindowData
    folder: Path

    @property
    def steps(self) -> int:
        """How many steps its training takes."""
        settings = self.data.settings
        windows = self.data.train.episodes * settings.windows_an_episode
        return settings.epochs * -(-windows // settings.batch)


@dataclass(frozen=True)
class Graduate:
    """A trained network, its learning curve (a record an epoch), and the seconds it took."""

    name: str
    network: ForecastNetwork
    curve: pd.DataFrame
    seconds: float


def train_networks(pupils: Sequence[Pupil]) -> list[Graduate]:
    """Train every network to the end, as many at once as there are cores for their threads.

    What comes of a network depends on its data and the seed alone: not on the number of cores, on
    the networks beside it, nor on kills in between.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "steps"
        done: Counts = np.memmap(path, dtype=np.int64, mode="w+", shape=(len(pupils),))
        with progress_bars({one.name: one.steps for one in pupils}, done.tolist):
            graduates: list[Graduate] = Parallel(_workers(pupils))(
                delayed(_learn)(one, StepCount(path, number, os.getpid()))
                for number, one in enumerate(pupils)
            )
    return graduates


@dataclass(frozen=True)
class StepCount:
    """Writes down how many steps a training has done, where the progress bars look.

    Attributes:
        path: of the counts of all trainings.
        number: of this one.
        master: the process that waits for its result.
    """

    path: Path
    number: int
    master: int

    def __call__(self, steps: int) -> None:
        """Write it down; a worker of a run that was killed ends, the next run waits for it."""
        if self.master not in (os.getpid(), os.getppid()):
            os._exit(1)
        done: Counts = np.memmap(self.path, dtype=np.int64, mode="r+")
        done[self.number] = steps


def _workers(pupils: Sequence[Pupil]) -> int:
    settings = [one.data.settings for one in pupils]
    if any(one.devices > 1 for one in settings):
        return 1  # devices have processes of their own
    threads = max(one.threads for one in settings)
    return max(1, min(int(cpu_count()) // threads, len(pupils)))


def _learn(pupil: Pupil, steps_done: StepCount) -> Graduate:
    """Take a network through its training.

    A worker of a run that was killed may still be at it: wait until it has noticed.
    """
    training = ForecastTraining(pupil.network, pupil.data.settings)
    with FileLock(pupil.folder / "lock"):
        train(training, pupil.data, pupil.folder, [Steps(steps_done)])
    return Graduate(pupil.name, pupil.network, pd.DataFrame(training.curve), training.seconds)
