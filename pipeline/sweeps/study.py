"""The study of a sweep: Optuna's record of all trials, in a file or a database."""

import warnings
from pathlib import Path

import optuna
from filelock import FileLock
from optuna.distributions import BaseDistribution
from optuna.exceptions import ExperimentalWarning
from optuna.pruners import MedianPruner
from optuna.samplers import BaseSampler, TPESampler
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages import RetryHeartbeatStaleTrialCallback as Retry
from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock
from optuna.trial import FrozenTrial, TrialState
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from pipeline.errors import InputError
from pipeline.sweeps.plan import Plan

HEARTBEAT, GRACE = (
    10,
    60,
)  # s between a worker's signs of life, and without any until it counts as dead
RETRIES = 3  # of a trial whose worker died; more would rather be the trial's own fault
TRIED = (TrialState.COMPLETE, TrialState.PRUNED)

warnings.filterwarnings("ignore", category=ExperimentalWarning)
optuna.logging.set_verbosity(optuna.logging.ERROR)


def create_study(plan: Plan, url: str | None) -> optuna.Study:
    """Make the study, if it is not there yet; its first trial are the parameters as they are."""
    study = optuna.create_study(
        storage=storage(plan, url),
        study_name=plan.study,
        direction=plan.settings.direction,
        load_if_exists=True,
    )
    defaults = plan.defaults()
    if defaults is not None and not study.trials:
        study.enqueue_trial(defaults)
    return study


def load_study(plan: Plan, name: str, url: str | None) -> optuna.Study:
    """Open a study that was made, to add trials to it."""
    pruning = plan.settings.pruning
    return optuna.load_study(
        study_name=name,
        storage=storage(plan, url),
        sampler=NumberedSampler(plan.params["seed"]),
        pruner=MedianPruner(pruning.first_trials, pruning.first_steps + 1),  # steps count from 1
    )


def storage(plan: Plan, url: str | None) -> BaseStorage:
    """Return where studies are kept: a file in scratch, or the database of a URL.

    Raises:
        InputError: the database cannot be used.
    """
    if url is None:
        plan.scratch.mkdir(parents=True, exist_ok=True)
        path = plan.scratch / "studies.jsonl"
        return JournalStorage(JournalFileBackend(str(path), _DyingLock(path)))
    place = _parsed(url)
    try:
        return RDBStorage(
            url,
            engine_kwargs={"pool_pre_ping": True},
            heartbeat_interval=HEARTBEAT,
            grace_period=GRACE,
            heartbeat_stale_trial_callback=Retry(RETRIES),
        )
    except (SQLAlchemyError, ImportError) as error:
        raise InputError(without_secrets(place), _reason(error, place)) from None


def without_secrets(place: URL) -> str:
    """The address of a database, without user, password and options."""
    return f"{place.get_backend_name()}://{place.host or ''}/{place.database or ''}"


def tried(study: optuna.Study) -> int:
    """How many trials have come to an end of their own."""
    return len(study.get_trials(deepcopy=False, states=TRIED))


def running(study: optuna.Study) -> list[FrozenTrial]:
    """The trials that are under way, or were when their worker died."""
    return study.get_trials(deepcopy=True, states=(TrialState.RUNNING,))


class NumberedSampler(BaseSampler):
    """A tree-structured Parzen estimator whose draws follow from the seed and the trial's number.

    So workers never draw alike, and a study that goes on later goes on as if it had not stopped.
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.estimator = TPESampler(seed=seed)

    def before_trial(self, study: optuna.Study, trial: FrozenTrial) -> None:
        """Begin the draws of a trial."""
        self.estimator = TPESampler(seed=(self.seed + 1_000_003 * trial.number) % 2**32)

    def infer_relative_search_space(
        self, study: optuna.Study, trial: FrozenTrial
    ) -> dict[str, BaseDistribution]:
        """Ask the estimator."""
        return self.estimator.infer_relative_search_space(study, trial)

    def sample_relative(
        self, study: optuna.Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, object]:
        """Ask the estimator."""
        return self.estimator.sample_relative(study, trial, search_space)

    def sample_independent(
        self,
        study: optuna.Study,
        trial: FrozenTrial,
        param_name: str,
        param_distribution: BaseDistribution,
    ) -> object:
        """Ask the estimator."""
        return self.estimator.sample_independent(study, trial, param_name, param_distribution)


class _DyingLock(JournalFileOpenLock):
    """A lock on a file that is free as soon as its holder has died; Optuna's own outlives it."""

    def __init__(self, path: Path) -> None:
        self.lock = FileLock(f"{path}.lock")

    def acquire(self) -> bool:
        """Wait for the lock."""
        self.lock.acquire()
        return True

    def release(self) -> None:
        """Let others have it."""
        self.lock.release()


def _parsed(url: str) -> URL:
    try:
        return make_url(url)
    except (ArgumentError, ValueError):
        problem = "is not the URL of a database, such as postgresql://user@host/database"
        raise InputError("--study", problem) from None


def _reason(error: Exception, place: URL) -> str:
    """What a database's driver says, without the secrets that it may repeat."""
    text = " ".join(str(getattr(error, "orig", None) or error).split())
    secrets = [str(place.password or ""), *map(str, place.query.values())]
    for secret in filter(None, secrets):
        text = text.replace(secret, "***")
    return f"cannot be used: {text[:300]}"
