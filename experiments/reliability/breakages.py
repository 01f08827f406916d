"""Faults other than kills of everything: what strikes, whether the run should bear it."""

import os
import signal
import socket
import sqlite3
import subprocess
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass
from pathlib import Path

import psutil

from experiments.reliability.disks import full_disk, read_only_disk
from experiments.reliability.repository import (
    Ended,
    Repository,
    awaited_stage,
    command_of,
    inhabitants,
)

INTERRUPTED = Path(__file__).parent / "interrupted"
WORKERS_GONE = 10.0  # s, within which workers of a stage of a stopped stage must have ended

Strike = Callable[[Repository, str], Ended]


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong while a stage runs."""

    name: str
    stage: str
    strike: Strike  # runs `dvc repro` with it
    says: str = (
        ""  # what the run must say, so that a fault that never struck is not taken for borne
    )
    borne: bool = False  # whether the run ends well all the same
    needs_root: bool = False  # to mount disks
    damages: str = ""  # a file of DVC's that it may damage, which is then repaired


@dataclass(frozen=True)
class Suffered:
    """A fault and what came of it."""

    fault: str
    stage: str
    happened: str  # how `dvc repro` ended
    as_expected: bool  # as it should, saying what it should, no other file of DVC's damaged
    message: str
    half_written: int  # outputs that stood under their name and were not whole
    same_hashes: bool  # of `dvc repro` without the fault: the undisturbed run's bytes and lock
    differences: str  # the files that say otherwise


def suffer(repository: Repository, fault: Fault) -> Suffered:
    """Let a stage meet a fault, and DVC run once more without it."""
    with repository.without(fault.stage):
        try:
            struck, kept = fault.strike(repository, fault.stage), True
        except AssertionError as error:  # what it must leave in order is not
            struck, kept = Ended(1, f"AssertionError: {error}"), False
        half = repository.half_written()
        ended, repaired = repository.recover()
        differences = repository.differences()
        if ended.status:
            differences = [ended.message, *differences]
    return Suffered(
        fault=fault.name,
        stage=fault.stage,
        happened="went on" if struck.status == 0 else "stopped",
        as_expected=kept
        and fault.borne == (struck.status == 0)
        and fault.says in struck.printed
        and repaired in ("", fault.damages),
        message=struck.message,
        half_written=len(half),
        same_hashes=not differences,
        differences="; ".join(differences),
    )


def _running(
    repository: Repository, stage: str
) -> tuple["subprocess.Popen[bytes]", psutil.Process]:
    """Start DVC and wait until it runs a stage; return both processes."""
    dvc = repository.start("dvc", "repro", stage)
    running = awaited_stage(dvc)
    assert running is not None and running[0] == stage, repository.printed()
    return dvc, running[1]


def _ended(repository: Repository, dvc: "subprocess.Popen[bytes]") -> Ended:
    status = dvc.wait()
    return Ended(status, repository.printed())


def on_disk(disk: Callable[[Path], AbstractContextManager[None]], name: str) -> Strike:
    """Return what runs a stage while a folder is on a disk of a kind."""

    def strike(repository: Repository, stage: str) -> Ended:
        with disk(repository.folder / name):
            return repository.reproduce(stage)

    return strike


def store_gone(repository: Repository, stage: str) -> Ended:
    """Run a stage while nothing answers at the address of the tracking server."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    return repository.reproduce(stage, MLFLOW_TRACKING_URI=f"http://127.0.0.1:{port}")


def store_hangs(repository: Repository, stage: str) -> Ended:
    """Run a stage while a tracking server takes connections and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        return repository.reproduce(stage, MLFLOW_TRACKING_URI=f"http://127.0.0.1:{port}")


def store_locked(repository: Repository, stage: str) -> Ended:
    """Run a stage while another process locks the store of runs."""
    store = repository.folder / "mlflow.db"
    with closing(sqlite3.connect(store, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        return repository.reproduce(stage)


def stage_alone_killed(
    repository: Repository, stage: str, number: signal.Signals = signal.SIGKILL
) -> Ended:
    """Send a signal to the process of a stage, and not to DVC, in the middle of the stage."""
    dvc, process = _running(repository, stage)
    time.sleep(repository.seconds[stage] / 2)
    process.send_signal(number)
    return _ended(repository, dvc)


def stage_stopped(repository: Repository, stage: str) -> Ended:
    """Stop a stage by SIGTERM; its workers must end."""
    ended = stage_alone_killed(repository, stage, signal.SIGTERM)
    deadline = time.monotonic() + WORKERS_GONE
    while left := [
        process
        for process in inhabitants(repository.folder)
        if any("joblib" in word for word in command_of(process))
    ]:
        assert time.monotonic() < deadline, f"{len(left)} workers live on"
        time.sleep(0.1)
    return ended


def dvc_alone_killed(repository: Repository, stage: str) -> Ended:
    """Kill DVC, whose stage lives on, and start it again at once."""
    dvc, _ = _running(repository, stage)
    time.sleep(repository.seconds[stage] / 2)
    dvc.kill()
    dvc.wait()
    return repository.reproduce(stage)


def killed_while_dvc_keeps(repository: Repository, stage: str) -> Ended:
    """Kill DVC while it moves a stage's outputs to its cache."""
    dvc, process = _running(repository, stage)
    process.wait()
    os.killpg(dvc.pid, signal.SIGKILL)
    return _ended(repository, dvc)


def lock_cut_short(repository: Repository, stage: str) -> Ended:
    """Leave dvc.lock as a kill while DVC writes it does, and start DVC again."""
    ended = repository.reproduce(stage)
    assert ended.status == 0, ended.printed
    lock = repository.folder / "dvc.lock"
    text = lock.read_text(encoding="utf-8")
    lock.write_text(text[: text.rindex("size:") + len("size:")], encoding="utf-8")
    return repository.reproduce(stage)


def interrupted(write: int) -> Strike:
    """Return what kills a stage in a write of its outputs, counted from 1."""

    def strike(repository: Repository, stage: str) -> Ended:
        return repository.reproduce(
            stage,
            PYTHONPATH=f"{INTERRUPTED}:{repository.folder}",
            INTERRUPTED_STAGE=stage,
            INTERRUPTED_WRITE=str(write),
        )

    return strike


WORKERS = "sim2sim"  # a stage with worker processes even where there is one policy
FULL, READ_ONLY = "the disk is full", "the disk can only be read"
UNRECORDED = "warning: MLflow has no complete record"
FAULTS = (
    *[
        Fault(f"disk of {name} full", stage, on_disk(full_disk, folder), FULL, needs_root=True)
        for name, folder, stage in (
            ("artifacts", "artifacts", "segment"),
            ("reports", "reports", "segment"),
            ("checkpoints", "scratch", "train_predictor"),
            ("checkpoints", "scratch", "train_policy"),
        )
    ],
    Fault(
        "disk of DVC's cache full",
        "segment",
        on_disk(full_disk, ".dvc/cache"),
        "failed to transfer",  # DVC goes on; the next run makes what its cache lacks
        borne=True,
        needs_root=True,
    ),
    *[
        Fault(
            f"disk of {folder} read-only",
            "segment",
            on_disk(read_only_disk, folder),
            READ_ONLY,
            needs_root=True,
        )
        for folder in ("artifacts", "reports")
    ],
    Fault("tracking server gone", "segment", store_gone, UNRECORDED, borne=True),
    Fault("tracking server hangs", "segment", store_hangs, UNRECORDED, borne=True),
    Fault("tracking store locked", "segment", store_locked, UNRECORDED, borne=True),
    Fault("stage alone killed", WORKERS, stage_alone_killed),
    Fault("stage told to stop (SIGTERM)", WORKERS, stage_stopped),
    Fault("stage told to stop (SIGTERM)", "train_predictor", stage_stopped),
    Fault("DVC alone killed, started again", "segment", dvc_alone_killed, borne=True),
    Fault("DVC alone killed, started again", "train_policy", dvc_alone_killed, borne=True),
    Fault("killed while DVC keeps outputs", "segment", killed_while_dvc_keeps, damages="rwlock"),
    Fault(
        "dvc.lock cut short",
        "segment",
        lock_cut_short,
        "dvc.lock' validation failed",
        damages="dvc.lock",
    ),
    *[
        Fault(f"{which} write cut short", stage, interrupted(number))
        for number, which, stage in (
            (1, "first", "ingest"),
            (1, "first", "segment"),
            (3, "third", "ingest"),
            (3, "third", "segment"),
            (1, "first", "train_predictor"),
        )
    ],
)
