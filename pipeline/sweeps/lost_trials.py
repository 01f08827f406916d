"""Lost trials: those whose worker died. They are marked as failed and wait to be tried again.

Optuna does that for studies in a database, which hears signs of life of every trial. For studies in
a file it is done here: each worker holds a lock that its death sets free, and signs its trials.
"""

import uuid
from datetime import datetime, timedelta
from pathlib import Path
from types import TracebackType
from typing import Self

import optuna
from filelock import FileLock, Timeout
from optuna.exceptions import UpdateFinishedTrialError
from optuna.storages import RetryHeartbeatStaleTrialCallback as Retry
from optuna.trial import FrozenTrial, Trial, TrialState

from pipeline.sweeps.storage import RETRIES
from pipeline.sweeps.study import running

WORKER = "worker"  # the signature, an attribute of trials
UNSIGNED = timedelta(minutes=1)  # trials are signed as they begin; by then they would have been


class Signature:
    """A worker among those of one machine, alive as long as it holds its lock.

    Args:
        folder: of the locks of all workers.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.name = folder, uuid.uuid4().hex
        self.lock = FileLock(folder / self.name)

    def __enter__(self) -> Self:
        self.lock.acquire()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.lock.release()

    def sign(self, trial: Trial) -> None:
        """Say whose trial this is."""
        trial.set_user_attr(WORKER, self.name)

    def retry_lost(self, study: optuna.Study) -> None:
        """Let the trials of a study in a file whose workers died be tried again."""
        for trial in running(study):
            if self._is_lost(trial):
                _retry(study, trial)

    def _is_lost(self, trial: FrozenTrial) -> bool:
        worker = trial.user_attrs.get(WORKER)
        if worker is None:
            begun = trial.datetime_start
            return begun is not None and datetime.now() - begun > UNSIGNED
        return worker != self.name and self._is_gone(worker)

    def _is_gone(self, worker: str) -> bool:
        try:
            with FileLock(self.folder / worker, timeout=0):
                return True
        except Timeout:
            return False


def _retry(study: optuna.Study, trial: FrozenTrial) -> None:
    """Mark a trial as failed and put it into the queue, unless another worker has just done so."""
    try:
        study.tell(trial.number, state=TrialState.FAIL)
    except (UpdateFinishedTrialError, ValueError):
        return
    trial.user_attrs.pop(WORKER, None)  # or the one that tries it again would pass for dead
    Retry(RETRIES)(study, trial)
