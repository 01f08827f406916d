"""Runs a sweep: worker processes run trials of one study, then the report is written."""

import multiprocessing
import os
import shutil
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import NoReturn

import optuna
from filelock import FileLock, Timeout

from rallygap.pipeline.runtime.console import refuse, warn
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.report import write_report
from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.sweeps.study import ended, open_study, retry_lost, running
from rallygap.pipeline.sweeps.trial import Train, run_trial, training_of

POLL = 2.0  # s, while other machines run the last trials


def run_sweep(sweep: Sweep, url: str | None, workers: int, wanted: int) -> list[str]:
    """Run trials until the study has as many as wanted, and write the report.

    Trials of killed workers are run again. The same command resumes a killed sweep. Workers that
    begin their last trials in the same moment run up to one trial too many each.

    Args:
        sweep: the sweep.
        url: of the study's database, which other machines may share; None keeps it in a file.
        workers: processes on this machine.
        wanted: trials, with those of earlier runs and other machines.

    Returns:
        The best parameters as flags of ``dvc exp run``.

    Raises:
        InputError: the database cannot be used, another process runs this sweep, or no trial was
            completed.
    """
    study = open_study(sweep, url)
    with _exclusive(sweep, url):
        while (before := ended(study)) < wanted:
            retry_lost(study, url)
            if before + len(running(study)) >= wanted:
                time.sleep(POLL)
            elif not _run_workers(sweep, url, workers, wanted) and ended(study) == before:
                break
        if not running(study):
            shutil.rmtree(sweep.scratch / "trials", ignore_errors=True)
    if (count := ended(study)) < wanted:
        warn(f"{count} of {wanted} trials have ended; run the same command again for the others")
    return write_report(sweep, study)


@contextmanager
def _exclusive(sweep: Sweep, url: str | None) -> Iterator[None]:
    """Refuse a second process on a study in a file, whose trials would look lost to the first."""
    if url is not None:
        yield
        return
    try:
        with FileLock(sweep.scratch / "lock", timeout=0):
            yield
    except Timeout:
        problem = "is already running; use --workers for more processes, or a database"
        raise InputError(f"sweep {sweep.name}", problem) from None


def _run_workers(sweep: Sweep, url: str | None, workers: int, wanted: int) -> bool:
    """Run worker processes to their end; return whether none failed or was killed."""
    process = multiprocessing.get_context("spawn").Process
    processes = [process(target=_worker, args=(sweep, url, wanted)) for _ in range(workers)]
    try:
        for one in processes:
            one.start()
        for one in processes:
            one.join()
    finally:
        for one in processes:
            if one.is_alive():
                one.terminate()
                one.join()
    return all(one.exitcode == 0 for one in processes)


def _worker(sweep: Sweep, url: str | None, wanted: int) -> None:
    """Run trials in a process of its own."""
    # The parent ends workers by SIGTERM. A SystemExit, unlike KeyboardInterrupt, leaves the trial
    # running in the study, so that it is retried.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _exit)
    os.environ["TTY_COMPATIBLE"] = "0"  # several progress bars would overwrite one another
    try:
        run_trials(open_study(sweep, url), sweep, training_of(sweep), wanted)
    except InputError as error:
        refuse(error)


def _exit(number: int, _: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


def run_trials(study: optuna.Study, sweep: Sweep, train: Train, wanted: int) -> None:
    """Run trials in this process until the study has as many as wanted, ended or running."""
    objective = partial(run_trial, sweep, train, _check_parent)
    while ended(study) + len(running(study)) < wanted:
        _check_parent()
        study.optimize(objective, n_trials=1)


def _check_parent() -> None:
    """End a worker whose parent was killed; its trial is retried."""
    parent = multiprocessing.parent_process()
    if parent is not None and not parent.is_alive():
        raise SystemExit(1)
