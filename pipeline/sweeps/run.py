"""A sweep from the command line: one study, workers that do its trials, then the report."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.runtime.console import warn
from pipeline.sweeps.plan import Plan
from pipeline.sweeps.report import write_report
from pipeline.sweeps.study import create_study, running, tried
from pipeline.sweeps.worker import STUDY


def run_sweep(plan: Plan, url: str | None, workers: int, wanted: int) -> list[str]:
    """Do trials until the study has as many as wanted, and report what it found.

    Args:
        plan: of the sweep.
        url: of the study's database; None keeps it in a file.
        workers: processes of this machine; those of others may work on the same database.
        wanted: trials, those of earlier calls and other machines counted.

    Returns:
        The best parameters as flags of ``dvc exp run``.

    Raises:
        InputError: the database cannot be used, or no trial was finished.
    """
    study = create_study(plan, url)
    needed = workers if tried(study) < wanted else 0
    with _working(plan, study.study_name, url, needed, wanted) as processes:
        for process in processes:
            process.wait()
    done = tried(study)
    if done < wanted:
        warn(f"{done} of {wanted} trials are done; the same command goes on with the others")
    if not running(study):
        shutil.rmtree(plan.scratch / "trials", ignore_errors=True)
    return write_report(plan, study)


@contextmanager
def _working(
    plan: Plan, study: str, url: str | None, workers: int, wanted: int
) -> Iterator[list["subprocess.Popen[bytes]"]]:
    """Start the workers; none outlives the block."""
    command = [sys.executable, "-m", "pipeline.sweeps.worker", plan.name, study, str(wanted)]
    # Progress bars of several trainings would overwrite one another.
    environment = {**os.environ, "TTY_COMPATIBLE": "0", **({STUDY: url} if url else {})}
    processes = [subprocess.Popen(command, cwd=plan.root, env=environment) for _ in range(workers)]
    try:
        yield processes
    finally:
        for process in processes:
            process.terminate()
            process.wait()
