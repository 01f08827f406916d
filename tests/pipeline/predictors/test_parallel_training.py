"""Networks are trained side by side: each as if alone, and no orphan goes on."""

import os
import subprocess
import sys
import textwrap
import time
from contextlib import suppress

import psutil
import pytest
from filelock import FileLock

from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.predictors.parallel_training import TrainingJob, train_networks
from tests.models.predictors.small_training import BRIEF, TINY, small_training


def job(folder, shape=TINY, settings=BRIEF):
    training, data = small_training(settings, shape=shape)
    return TrainingJob(f"{shape.kind}", training.network, data, folder / shape.kind)


def test_a_training_waits_for_who_else_is_at_it(tmp_path, monkeypatch):
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    one = job(tmp_path)
    seen = []

    def locked(*_):
        other = FileLock(one.folder / "lock", is_singleton=False)
        with pytest.raises(TimeoutError):
            other.acquire(timeout=0)
        seen.append(other)

    monkeypatch.setattr(ForecastTraining, "on_train_epoch_start", locked)
    train_networks([one])
    assert len(seen) == BRIEF.epochs


ORPHAN = """
    import sys
    from pathlib import Path
    from rallygap.pipeline.predictors.parallel_training import train_networks
    from tests.models.predictors.small_training import BRIEF, TINY, TINY_TAE, changed
    from tests.pipeline.predictors.test_parallel_training import job
    long = changed(BRIEF, epochs=10_000)
    train_networks([job(Path(sys.argv[1]), shape, long) for shape in (TINY, TINY_TAE)])
"""


@pytest.mark.slow
def test_workers_of_a_run_that_was_killed_stop(tmp_path):
    environment = {**os.environ, "LOKY_MAX_CPU_COUNT": "2"}
    command = [sys.executable, "-c", textwrap.dedent(ORPHAN), str(tmp_path)]
    run = subprocess.Popen(command, env=environment)
    checkpoints = [tmp_path / kind / "last.ckpt" for kind in ("transformer", "tae")]
    wait_for(lambda: all(path.exists() for path in checkpoints))
    workers = psutil.Process(run.pid).children(recursive=True)
    run.kill()
    run.wait()
    for path in checkpoints:
        FileLock(path.with_name("lock"), timeout=60).acquire()
    wait_for(lambda: not any(busy(worker) for worker in workers), longest=10)


def busy(process):
    with suppress(psutil.NoSuchProcess):
        return process.cpu_percent(interval=0.2) > 20


def wait_for(condition, longest=300):
    for _ in range(longest * 5):
        if condition():
            return
        time.sleep(0.2)
    raise AssertionError("it never came")
