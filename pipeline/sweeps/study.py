"""The Optuna study of a sweep: in a file of this machine, or in a database shared by machines."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import optuna
from optuna.exceptions import ExperimentalWarning
from optuna.pruners import MedianPruner
from optuna.samplers import TPESampler
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages import RetryHeartbeatStaleTrialCallback as Retry
from optuna.storages.journal import JournalFileBackend
from optuna.trial import FrozenTrial, TrialState
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.tracking.recording import process_lives

HEARTBEAT = 10  # s between heartbeats of a trial in a database
GRACE = 60  # s without a heartbeat after which a trial counts as lost
RETRIES = 3  # of a lost trial
ENDED = (TrialState.COMPLETE, TrialState.PRUNED)
PROCESS = "process"  # attribute of a trial: who runs it

warnings.filterwarnings("ignore", category=ExperimentalWarning)
optuna.logging.set_verbosity(optuna.logging.ERROR)


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

    Args:
        sweep: the sweep.
        url: of a database; None keeps the study in a file under ``scratch``.

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

    In a database Optuna does the same by heartbeats, also for other machines.
    """
    for trial in study.get_trials(states=(TrialState.RUNNING,)):
        worker = trial.user_attrs.get(PROCESS)
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
