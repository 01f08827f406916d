"""Runs trials of a sweep in this process, and writes the report of its study.

More workers are more processes of the same command: they share the study's storage, as Optuna's
documentation has it.
"""

from functools import partial

import optuna
from filelock import FileLock
from optuna.study import MaxTrialsCallback

from rallygap.pipeline.sweeps.report import write_report
from rallygap.pipeline.sweeps.settings import Sweep, Train
from rallygap.pipeline.sweeps.study import ENDED, ended, open_study, retry_lost
from rallygap.pipeline.sweeps.trial import run_trial, training_of


def run_sweep(sweep: Sweep, url: str | None, wanted: int) -> list[str]:
    """Run trials until the study has as many as wanted, and write the report.

    Trials of killed workers are run again. Workers that begin their last trials in the same moment
    run up to one trial too many each.

    Args:
        sweep: the sweep.
        url: of the study's database, which other machines may share; None keeps it in a file.
        wanted: trials, with those of earlier runs and other workers.

    Returns:
        The best parameters as flags of ``dvc exp run``.

    Raises:
        InputError: the data are missing, the database cannot be used, or no trial was completed.
    """
    sweep.scratch.mkdir(parents=True, exist_ok=True)
    with FileLock(sweep.scratch / "lock"):  # two workers would both queue the first trial
        study = open_study(sweep, url)
        retry_lost(study)
    if ended(study) < wanted:
        run_trials(study, sweep, training_of(sweep), wanted)
    return write_report(sweep, study)


def run_trials(study: optuna.Study, sweep: Sweep, train: Train, wanted: int) -> None:
    """Run trials until the study has as many as wanted."""
    stop = MaxTrialsCallback(wanted, states=ENDED)
    study.optimize(partial(run_trial, sweep, train), callbacks=[stop])
