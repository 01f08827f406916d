"""What grows how, on one process and on two (`python -m benchmarks.scale`; minutes).

Every work is done once as it is, once twice as large, and that once more on two processes. Twice as
large is one hall with twice the balls, and one training on twice the balls; of questions and
policies, which are independent, twice as many. Writes
``reports/costs/scale.csv`` and ``scale.json`` and fills in docs/scale.md. Give the machine nothing
else to do meanwhile.
"""

import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import lightning
import numpy as np
import pandas as pd
import torch
from joblib.externals.loky import get_reusable_executor
from rich.console import Console

from benchmarks.policy_training import LEARNING, PARAMS, SEED, TASK
from benchmarks.scale_page import MEASURED, SIZES, fill_page
from models.ball.catalogue import catalogue
from models.exam.design.questions import Question
from models.exam.design.trial import Trial
from models.exam.methods.registry import METHODS
from models.exam.run_question import sit
from models.policy.learning import learn_leg
from models.predictors.learned import build_network
from models.predictors.training import ForecastTraining, WindowData
from models.predictors.window_dataset import tracks
from models.segmentation.tables import Segmented
from pipeline.evaluation.costs import machine
from pipeline.exam.records import OURS
from pipeline.io.artifacts import read_table, write_csv, write_json
from pipeline.io.episodes import _episode
from pipeline.predictors.trainer import train
from pipeline.runtime.parallel import parallel
from pipeline.runtime.stage_run import StageRun
from pipeline.sources.gather import gather
from stages.segment import _cut
from tests.models.predictors.schooling import balls
from tests.pipeline.sources.made_up import ARENA

ROOT = Path(__file__).parents[1]
HALL = ARENA.model_copy(update={"game_episodes": 1500, "cannon_shots": 1500})
SHOTS = 100  # of a question
NOT_NOMINAL = sorted(set(catalogue()) - set(TASK.simulator.effects))
LEG = LEARNING.model_copy(update={"legs": 1, "ticks": 3200, "warm_up": 320})
BALLS = 1000  # whose windows the predictor learns from
EPOCHS = 4

SETTINGS = ((1, 1), (1, 2), (2, 2))  # processes, and how many times the work


@dataclass(frozen=True)
class Work:
    """Tasks of one kind: what they count, how many there are, and what one of them does."""

    name: str
    unit: str
    tasks: int
    do: Callable[[int], int]


def sit_question(number: int, withheld: Sequence[str] = ()) -> int:
    """Let our method answer a question of the exam."""
    trial = Trial(
        f"clean/{number}", TASK.simulator, shots=SHOTS, withheld=tuple(withheld), seed=1000 + number
    )
    sit(Question("clean", trial), {OURS: METHODS[OURS]})
    return 1


def sit_with_half_the_effects(number: int) -> int:
    """Let it answer with every other effect of its catalogue withheld."""
    return sit_question(number, NOT_NOMINAL[::2])


def learn(seed: int) -> int:
    """Take a policy through a short leg; return its control ticks."""
    with tempfile.TemporaryDirectory() as folder:
        learn_leg(TASK, LEG, seed, 0, None, Path(folder))
    return LEG.ticks


WORKS = (
    Work(f"verdicts on {SHOTS} shots", "questions of the exam", 2, sit_question),
    Work("verdicts with half the effects", "such questions", 2, sit_with_half_the_effects),
    Work("train policies", "control ticks", 1, learn),
)


def use(processes: int) -> None:
    """Have all that runs side by side run on so many processes."""
    os.environ["LOKY_MAX_CPU_COUNT"] = str(processes)
    # What workers of another work import counts as a leak, for which loky ends them meanwhile.
    get_reusable_executor().shutdown()


def measure(work: Work, processes: int, times: int) -> dict[str, Any]:
    """Do a work so many times over, on so many processes; return a row of the table."""
    use(processes)
    list(parallel([partial(work.do, 0)] * processes))  # started, imported, compiled
    start = time.monotonic()
    done = sum(parallel([partial(work.do, SEED + k) for k in range(times * work.tasks)]))
    return row(work.name, work.unit, processes, done, time.monotonic() - start)


def measure_balls(processes: int, times: int) -> dict[str, Any]:
    """Simulate a hall with so many times the balls, write and cut them."""
    use(processes)
    cut_hall(1)  # started, imported, compiled
    start = time.monotonic()
    done = cut_hall(times)
    return row(
        "simulate, write and cut balls", "episodes", processes, done, time.monotonic() - start
    )


def cut_hall(times: int) -> int:
    """Return how many episodes a hall with so many times the balls has."""
    with tempfile.TemporaryDirectory() as root:
        return len(cut(Path(root), times).episodes)


def cut(root: Path, times: int = 1) -> Segmented:
    """Do what `ingest` and `segment` do to a hall with so many times the balls."""
    shots = {name: times * getattr(HALL, name) for name in ("game_episodes", "cannon_shots")}
    settings = PARAMS.ingest.model_copy(update={"arena": HALL.model_copy(update=shots)})
    gathered = gather(settings, SEED, root / "artifacts" / "ingest")
    _, found, _ = _cut(StageRun("segment", root, PARAMS), gathered.manifest, {})
    return found


def measure_training(processes: int, times: int) -> dict[str, Any]:
    """Train the predictor of params.yaml on so many times the balls, which are made up.

    Its start is not counted.
    """
    settings = PARAMS.train_predictor
    (shape,) = list(settings.networks.values())[:1]
    changed = settings.training.model_copy(update={"epochs": EPOCHS, "devices": processes})
    lightning.seed_everything(SEED, verbose=False)
    training = ForecastTraining(build_network(shape), changed)
    data = WindowData(balls(times * BALLS, 0), balls(3, 1), changed, SEED)
    data.fit_normaliser(training.network)
    with tempfile.TemporaryDirectory() as folder:
        train(training, data, Path(folder))
    done = data.train.episodes * changed.windows_an_episode * changed.epochs
    return row("train the predictor", "windows", processes, done, training.seconds)


def row(work: str, unit: str, processes: int, units: int, seconds: float) -> dict[str, Any]:
    """Return a row of the table."""
    rate = units / seconds
    return {
        "work": work, "unit": unit, "processes": processes, "units": units,
        "seconds": seconds, "per_second": rate,
    }  # fmt: skip


def sizes() -> dict[str, float]:
    """Return what an episode takes: bytes on disk in all tables, and in memory while it teaches."""
    use(1)
    with tempfile.TemporaryDirectory() as root:
        cut(Path(root))
        disk = sum(path.stat().st_size for path in Path(root).rglob("*.parquet"))
        samples = read_table(Path(root) / "artifacts" / "segment" / "samples.parquet")
    taught = [_episode(rows) for _, rows in samples.groupby("episode_id")]
    held = [*taught, tracks(taught)]  # a training has read the ones and made the others of them
    arrays = (part for one in held for part in vars(one).values())
    memory = sum(part.nbytes for part in arrays if isinstance(part, np.ndarray | torch.Tensor))
    return {"disk_bytes": disk / len(taught), "memory_bytes": memory / len(taught)}


def main() -> None:
    """Measure, write, fill in the page, print."""
    rows = [measure_training(*setting) for setting in SETTINGS]
    rows += [measure_balls(*setting) for setting in SETTINGS]
    rows += [measure(work, *setting) for work in WORKS for setting in SETTINGS]
    write_csv(MEASURED, pd.DataFrame(rows), digits=4)
    write_json(SIZES, {**machine(ROOT), **{k: float(f"{v:.4g}") for k, v in sizes().items()}})
    fill_page()
    Console().print(MEASURED.read_text())


if __name__ == "__main__":
    main()
