"""The study of a sweep: its storage, and the trials that a worker runs.

It is in a file of this machine, or in a database shared by machines. More workers are more
processes of the same command, as Optuna's documentation has it.
"""

import math
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import optuna
import typer
from filelock import FileLock
from optuna import TrialPruned
from optuna.exceptions import ExperimentalWarning
from optuna.pruners import MedianPruner
from optuna.samplers import TPESampler
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages import RetryHeartbeatStaleTrialCallback as Retry
from optuna.storages.journal import JournalFileBackend
from optuna.study import MaxTrialsCallback
from optuna.trial import FrozenTrial, TrialState
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.sweeps.report import write_report
from rallygap.pipeline.sweeps.settings import PredictorSweep, Sweep, Train
from rallygap.pipeline.tracking.results import Results
from rallygap.pipeline.tracking.runs import (
    ParentRun,
    RunStart,
    process_lives,
    this_process,
    tracked_run,
)

HEARTBEAT = 10  # s between heartbeats of a trial in a database
GRACE = 60  # s without a heartbeat after which a trial counts as lost
RETRIES = 3  # of a lost trial
ENDED = (TrialState.COMPLETE, TrialState.PRUNED)
PROCESS = "process"  # attribute of a trial: who runs it

warnings.filterwarnings("ignore", category=ExperimentalWarning)
optuna.logging.set_verbosity(optuna.logging.ERROR)


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
    lock = FileLock(sweep.scratch / "lock")
    with lock:  # two workers would both queue the first trial
        study = open_study(sweep, url)
        if url is None:
            retry_lost(study)
    if ended(study) < wanted:
        run_trials(study, sweep, training_of(sweep), wanted)
    with lock:  # a slower worker would replace a report that has more trials
        return write_report(sweep, study)


def training_of(sweep: Sweep) -> Train:
    """Return the training of a sweep's trials, with its data in memory.

    Raises:
        InputError: the data are missing.
    """
    if isinstance(sweep.settings, PredictorSweep):
        from rallygap.pipeline.sweeps.predictor import PredictorTraining

        return PredictorTraining(sweep.root, sweep.settings, sweep.trial_params({})).score
    from rallygap.pipeline.sweeps.policy import score_policy

    return partial(score_policy, sweep.settings)


def run_trials(study: optuna.Study, sweep: Sweep, train: Train, wanted: int) -> None:
    """Run trials until the study has as many as wanted."""
    stop = MaxTrialsCallback(wanted, states=ENDED)
    study.optimize(partial(run_trial, sweep, train), callbacks=[stop])


def run_trial(sweep: Sweep, train: Train, trial: optuna.Trial) -> float:
    """Run a trial and return its score.

    Raises:
        TrialPruned: the score is not finite or worse than the median of the other trials, or the
            suggested values are invalid together.
        SystemExit: the user interrupted it; the next command runs the trial again.
    """
    settings, scores = sweep.settings, dict[str, float]()

    def report(step: int, score: float) -> None:
        scores[str(step)] = score
        trial.report(score, step)
        if not math.isfinite(score) or trial.should_prune():
            raise TrialPruned(f"{settings.score} {score:.4g} after {settings.step} {step}")

    trial.set_user_attr(PROCESS, this_process())
    try:
        params = sweep.trial_params(sweep.suggest(trial))
    except InputError as error:
        raise TrialPruned(str(error)) from None
    start = _run_start(sweep, trial, params)
    metric = settings.score.replace(" ", "_")
    with tracked_run(start, lambda: Results({metric: scores})), TemporaryDirectory() as checkpoints:
        try:
            result: float | TrialPruned = train(params, Path(checkpoints), report)
        except TrialPruned as pruned:  # for MLflow the run is finished
            result = pruned
        except KeyboardInterrupt:  # Optuna would take the trial for a failed one
            raise SystemExit(128 + signal.SIGINT) from None
    if isinstance(result, TrialPruned):
        typer.echo(f"trial {trial.number}: pruned, {result}")
        raise result
    typer.echo(f"trial {trial.number}: {settings.score} {result:.4g}")
    return result


def _run_start(sweep: Sweep, trial: optuna.Trial, params: Params) -> RunStart:
    """Describe a trial's MLflow run, nested in the run of the sweep."""
    command = f"rallygap sweep {sweep.name}"
    shared = {"mlflow.source.name": command}
    if commit := git_commit(sweep.root):
        shared["mlflow.source.git.commit"] = commit
    parent = ParentRun(trial.study.study_name, command, shared)
    own = {"rallygap.study": parent.key, "rallygap.trial": str(trial.number)}
    used = params.model_dump(mode="json", include={"seed", sweep.settings.stage})
    return RunStart(f"trial {trial.number}", used, {**shared, **own}, parent)


class NumberedSampler(TPESampler):
    """Optuna's TPE sampler with random draws that follow from a seed and the trial's number.

    Workers therefore never draw the same values, and a resumed study draws as one without a break.
    """

    def __init__(self, seed: int) -> None:
        super().__init__(seed=seed)
        self.study_seed = seed

    def before_trial(self, study: optuna.Study, trial: FrozenTrial) -> None:
        """Seed the draws of a trial."""
        super().__init__(seed=(self.study_seed + 1_000_003 * trial.number) % 2**32)


def open_study(sweep: Sweep, url: str | None) -> optuna.Study:
    """Open the study of a sweep; create it if missing, with params.yaml as its first trial.

    Without the URL of a database it is kept in a file under ``scratch``.

    Raises:
        InputError: the database cannot be used, or the data are missing.
    """
    pruning, name = sweep.settings.pruning, sweep.study
    with _database_errors(url):
        study = optuna.create_study(
            storage=_storage(sweep, url),
            sampler=NumberedSampler(sweep.params["seed"]),
            pruner=MedianPruner(pruning.first_trials, pruning.first_steps + 1),  # steps from 1
            study_name=name,
            direction=sweep.settings.direction,
            load_if_exists=True,
        )
        defaults = sweep.defaults()
        if defaults is not None and not study.trials:
            study.enqueue_trial(defaults)
    return study


def ended(study: optuna.Study) -> int:
    """Return the number of trials that were completed or pruned."""
    return len(study.get_trials(False, states=ENDED))


def retry_lost(study: optuna.Study) -> None:
    """Mark trials of dead workers of this machine as failed, and queue their values again.

    In a database Optuna does the same by heartbeats, because its workers may be on other machines.
    """
    for trial in study.get_trials(states=(TrialState.RUNNING,)):
        worker = trial.user_attrs.pop(PROCESS, None)
        if worker is not None and not process_lives(worker):
            study.tell(trial.number, state=TrialState.FAIL)
            Retry(RETRIES)(study, trial)


def _storage(sweep: Sweep, url: str | None) -> BaseStorage:
    if url is None:
        sweep.scratch.mkdir(parents=True, exist_ok=True)
        return JournalStorage(JournalFileBackend(str(sweep.scratch / "studies.jsonl")))
    return RDBStorage(
        # Quotes the braces, which Optuna would otherwise fill in.
        _parsed(url).render_as_string(hide_password=False),
        engine_kwargs={"pool_pre_ping": True},
        heartbeat_interval=HEARTBEAT,
        grace_period=GRACE,
        heartbeat_stale_trial_callback=Retry(RETRIES),
    )


def _parsed(url: str) -> URL:
    try:
        return make_url(url)
    except (ArgumentError, ValueError):
        problem = "is not the URL of a database, such as postgresql://user@host/database"
        raise InputError("--study", problem) from None


@contextmanager
def _database_errors(url: str | None) -> Iterator[None]:
    """Report errors of a database without user, password and options of its URL."""
    try:
        yield
    except (SQLAlchemyError, ImportError) as error:
        parsed = _parsed(url or "")
        text = " ".join(str(getattr(error, "orig", None) or error).split())
        for secret in filter(None, [str(parsed.password or ""), *map(str, parsed.query.values())]):
            text = text.replace(secret, "***")
        where = f"{parsed.get_backend_name()}://{parsed.host or ''}/{parsed.database or ''}"
        raise InputError(where, f"cannot be used: {text[:300]}") from None
