"""How costs grow with the work, on one process and on two; minutes.

Every work is measured once, then twice as large, then that on two processes. Writes
``reports/costs/scale.csv`` and ``scale.json``, whose table docs/scale.md shows. Run
nothing else meanwhile.
"""

import os
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import lightning
import numpy as np
import pandas as pd
import torch
from joblib.externals.loky import get_reusable_executor

from experiments.benchmarks.comparison import write_measured
from experiments.benchmarks.policy_training import LEARNING, PARAMS, SEED, TASK
from experiments.exam.design.question import Question
from experiments.exam.methods.registry import METHODS, RALLYGAP
from experiments.exam.runner import run_question
from experiments.exam.simulate.trial import Trial
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.policy.learning import learn_iteration
from rallygap.models.predictors.learned import build_network
from rallygap.models.predictors.training import ForecastTraining, WindowData
from rallygap.models.predictors.window_dataset import build_tracks
from rallygap.models.predictors.windows import Episode
from rallygap.models.segmentation.tables import Segmented
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.io.episodes import as_episode
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.segmentation.cut_recordings import cut_recordings
from rallygap.pipeline.sources.gather import gather

ARENA = PARAMS.ingest.arena
ARENA_SHOTS = {"game_episodes": 1500, "cannon_shots": 1500}
SHOTS = 100  # per question of the exam
NOT_NOMINAL = sorted(set(catalogue()) - set(TASK.simulator.effects))
SHORT = LEARNING.model_copy(update={"iterations": 1, "steps_per_iteration": 3200, "warm_up": 320})
EPISODES = 1000  # that the predictor learns from
VALIDATION_EPISODES = 3
EPOCHS = 4

SETTINGS = ((1, 1), (1, 2), (2, 2))  # processes, multiple of the work


def answer_question(number: int, withheld: Sequence[str] = ()) -> int:
    """Let rallygap answer a question of the exam."""
    trial = Trial(
        f"clean/{number}", TASK.simulator, shots=SHOTS, withheld=tuple(withheld), seed=1000 + number
    )
    run_question(Question("clean", trial), {RALLYGAP: METHODS[RALLYGAP]})
    return 1


def learn(seed: int) -> int:
    """Train a policy for a short training iteration; return its control steps."""
    with tempfile.TemporaryDirectory() as folder:
        learn_iteration(TASK, SHORT, seed, 0, None, Path(folder))
    return SHORT.steps_per_iteration


# Independent tasks: their name, the unit that they count, their number, and one of them.
WORKS: tuple[tuple[str, str, int, Callable[[int], int]], ...] = (
    (f"verdicts on {SHOTS} shots", "questions of the exam", 2, answer_question),
    (
        "verdicts with half the effects",
        "questions of the exam, half the effects",
        2,
        partial(answer_question, withheld=NOT_NOMINAL[::2]),
    ),
    ("train policies", "control steps", 1, learn),
)


def set_processes(processes: int) -> None:
    """Let parallel tasks run on a number of processes."""
    os.environ["LOKY_MAX_CPU_COUNT"] = str(processes)
    # loky takes the memory of other works' imports for a leak, and would restart workers.
    get_reusable_executor().shutdown()


def measure(
    work: str, unit: str, processes: int, do: Callable[[], int], warm_up: Callable[[], object]
) -> dict[str, Any]:
    """Measure a work on some processes, after a warm-up; return a row of the table."""
    set_processes(processes)
    warm_up()  # start, import, compile
    start = time.monotonic()
    done = do()
    return row(work, unit, processes, done, time.monotonic() - start)


def measure_tasks(
    name: str, unit: str, count: int, do: Callable[[int], int], processes: int, times: int
) -> dict[str, Any]:
    """Measure a multiple of independent tasks."""
    tasks = [partial(do, SEED + k) for k in range(times * count)]
    return measure(
        name,
        unit,
        processes,
        lambda: sum(parallel(tasks)),
        lambda: list(parallel([partial(do, 0)] * processes)),
    )


def segment_arena(times: int) -> int:
    """Ingest and segment an arena; return the number of episodes."""
    with tempfile.TemporaryDirectory() as root:
        return len(segmented(Path(root), times).episodes)


def measure_arena(processes: int, times: int) -> dict[str, Any]:
    """Measure ingest and segment of an arena with a multiple of the shots."""
    work = "simulate, write and segment episodes"
    do, warm_up = partial(segment_arena, times), partial(segment_arena, 1)
    return measure(work, "episodes", processes, do, warm_up)


def segmented(root: Path, times: int = 1) -> Segmented:
    """Run `ingest` and `segment` on an arena with a multiple of the shots."""
    shots = {name: times * count for name, count in ARENA_SHOTS.items()}
    settings = PARAMS.ingest.model_copy(update={"arena": ARENA.model_copy(update=shots)})
    artifacts = root / "artifacts"
    gathered = gather(settings, SEED, artifacts / "ingest")
    recordings = artifacts / "ingest" / "recordings.parquet"
    samples = artifacts / "segment" / "samples.parquet"
    return cut_recordings(recordings, samples, gathered.manifest, PARAMS.segment).segmented


def measure_training(episodes: list[Episode], processes: int, times: int) -> dict[str, Any]:
    """Measure the training of the predictor on a multiple of the episodes, without its start."""
    settings = PARAMS.train_predictor
    shape = settings.networks["transformer"]
    changed = settings.training.model_copy(update={"epochs": EPOCHS, "devices": processes})
    lightning.seed_everything(SEED, verbose=False)
    training = ForecastTraining(build_network(shape), changed)
    learned, validation = episodes[: times * EPISODES], episodes[-VALIDATION_EPISODES:]
    data = WindowData(build_tracks(learned), build_tracks(validation), changed, SEED)
    data.fit_normaliser(training.network)
    with tempfile.TemporaryDirectory() as folder:
        train(training, data, Path(folder))
    done = data.train.episodes * changed.windows_per_episode * changed.epochs
    return row("train the predictor", "windows", processes, done, training.seconds)


def row(work: str, unit: str, processes: int, units: int, seconds: float) -> dict[str, Any]:
    """Return a row of the table."""
    rate = units / seconds
    return {
        "work": work, "unit": unit, "processes": processes, "units": units,
        "seconds": seconds, "per_second": rate,
    }  # fmt: skip


def arena_episodes() -> tuple[list[Episode], float]:
    """Return the episodes of an arena, and the bytes of each on disk in all tables."""
    set_processes(1)
    with tempfile.TemporaryDirectory() as root:
        segmented(Path(root))
        disk = sum(path.stat().st_size for path in Path(root).rglob("*.parquet"))
        samples = read_table(Path(root) / "artifacts" / "segment" / "samples.parquet")
    episodes = [as_episode(rows) for _, rows in samples.groupby("episode_id")]
    return episodes, disk / len(episodes)


def memory_of(episodes: list[Episode]) -> float:
    """Return the bytes of an episode in the memory of a training."""
    held = [*episodes, build_tracks(episodes)]  # a training holds both
    arrays = (part for holder in held for part in vars(holder).values())
    memory = sum(part.nbytes for part in arrays if isinstance(part, np.ndarray | torch.Tensor))
    return memory / len(episodes)


def main() -> None:
    """Measure, write, print."""
    episodes, disk = arena_episodes()
    rows = [measure_training(episodes, *setting) for setting in SETTINGS]
    rows += [measure_arena(*setting) for setting in SETTINGS]
    rows += [measure_tasks(*work, *setting) for work in WORKS for setting in SETTINGS]
    memory = memory_of(episodes)
    write_measured("scale", pd.DataFrame(rows), disk_bytes=disk, memory_bytes=memory)


if __name__ == "__main__":
    main()
