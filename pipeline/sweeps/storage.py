"""Where studies are kept: a file in scratch, or a database that several machines share."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages import RetryHeartbeatStaleTrialCallback as Retry
from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock
from sqlalchemy import create_engine, func, select
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from pipeline.runtime.errors import InputError
from pipeline.sweeps.plan import Plan

HEARTBEAT = 10  # s between a worker's signs of life
GRACE = 60  # s without any, until it counts as dead
RETRIES = 3  # of a trial whose worker died; more would rather be the trial's own fault
MAKING = zlib.crc32(b"rallygap sweep")  # the lock of who makes a study, among those of a database


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
    with _named(place):
        return RDBStorage(
            place.render_as_string(hide_password=False),  # quoted: Optuna fills in what has braces
            engine_kwargs={"pool_pre_ping": True},
            heartbeat_interval=HEARTBEAT,
            grace_period=GRACE,
            heartbeat_stale_trial_callback=Retry(RETRIES),
        )


@contextmanager
def alone(url: str | None) -> Iterator[None]:
    """Let nobody else make tables or a study in a PostgreSQL database during this block.

    Two that begin at once on an empty one would both make the tables, and one would fail. The
    server frees the lock when its holder dies.

    Raises:
        InputError: the database cannot be used.
    """
    place = None if url is None else _parsed(url)
    if place is None or place.get_backend_name() != "postgresql":
        yield
        return
    with _named(place), create_engine(place).begin() as connection:
        connection.execute(select(func.pg_advisory_xact_lock(MAKING)))
        yield


@contextmanager
def _named(place: URL) -> Iterator[None]:
    """Name a database that cannot be used, without the secrets of its URL."""
    try:
        yield
    except (SQLAlchemyError, ImportError) as error:
        raise InputError(_without_secrets(place), _reason(error, place)) from None


def _without_secrets(place: URL) -> str:
    """The address of a database, without user, password and options."""
    return f"{place.get_backend_name()}://{place.host or ''}/{place.database or ''}"


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
