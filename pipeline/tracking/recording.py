"""Tracking as a stage sees it: a recorder process beside it, which can never hold it up.

The recorder (``recorder.py``) opens the MLflow store while the stage works, and takes the
results when it ends. The stage waits ``PATIENCE`` for it and no longer: a store that is down or
locked costs a warning, a slow one is written in the background. A stage that is killed is recorded
as killed, because the recorder outlives it.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from pipeline.io.artifacts import write_json
from pipeline.runtime.console import warn
from pipeline.runtime.guard import guarded
from pipeline.runtime.provenance import Provenance, git_commit, repository_root
from pipeline.runtime.scratch import keep_timings, scratch_kept

PATIENCE = 5.0  # s, that a finished stage waits for its recorder


class Recorder:
    """The process that writes one stage into MLflow.

    Args:
        start: what is known when the stage starts; see ``description``.
    """

    def __init__(self, start: dict[str, Any]) -> None:
        self.stage = start["stage"]
        self.messages = _delivered(start)
        self.complaints = tempfile.TemporaryFile("w+")  # noqa: SIM115
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pipeline.tracking.recorder", str(self.messages)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self.complaints,
            # An interrupt from the keyboard stops the stage; the recorder writes that down.
            start_new_session=True,
        )

    def finish(self, end: dict[str, Any]) -> None:
        """Hand over what the stage left and wait, but not for long."""
        try:
            write_json(self.messages / "end.json", end)
            self.process.communicate(timeout=PATIENCE)
        except OSError as error:
            warn(f"MLflow has no complete record of {self.stage}: {error}")
        except subprocess.TimeoutExpired:
            warn(f"MLflow is slow or locked; {self.stage} is recorded in the background, if at all")
        else:
            if self.process.returncode != 0:
                shutil.rmtree(self.messages, ignore_errors=True)  # where the recorder was killed
                warn(f"MLflow has no complete record of {self.stage}: {self._last_complaint()}")

    def _last_complaint(self) -> str:
        if self.process.returncode < 0:
            return "the recorder was killed"
        self.complaints.seek(0)
        return (self.complaints.read().splitlines() or ["it says nothing"])[-1]


def _delivered(start: dict[str, Any]) -> Path:
    """Return a new folder for messages to a recorder, with the first of them."""
    messages = Path(tempfile.mkdtemp(prefix="rallygap-"))
    try:
        write_json(messages / "start.json", start)
    except OSError:
        shutil.rmtree(messages)
        raise
    return messages


@contextmanager
def recorded(
    stage: str,
    origin: Provenance,
    params: dict[str, Any],
    results: Callable[[], dict[str, Any]],
) -> Iterator[None]:
    """Guard and record the stage of this block, and keep what it leaves beside its outputs.

    Args:
        stage: its name.
        origin: its command and fingerprint.
        params: its parameters.
        results: called at the end, whichever it is, for metrics, input data sets and figures.
    """
    with guarded(stage), recording(description(stage, origin, params), results):
        with scratch_kept(stage, origin.fingerprint):
            yield
        keep_timings(stage, origin.fingerprint, results()["metrics"].get("timings", {}))


@contextmanager
def recording(start: dict[str, Any], results: Callable[[], dict[str, Any]]) -> Iterator[None]:
    """Record what is done in this block, and how it ends.

    Args:
        start: as for ``Recorder``.
        results: called at the end, whichever it is, for what is left.
    """
    recorder = _started(start)
    status = "FAILED"
    try:
        yield
        status = "FINISHED"
    except (KeyboardInterrupt, SystemExit):
        status = "KILLED"
        raise
    finally:
        if recorder is not None:
            recorder.finish({**results(), "status": status, "time": now()})


def _started(start: dict[str, Any]) -> Recorder | None:
    """Start the recorder; None, and a warning, where there is no room for what it must be told."""
    try:
        return Recorder(start)
    except OSError as error:
        warn(f"MLflow has no record of {start['stage']}: {error}")
        return None


def description(stage: str, origin: Provenance, params: dict[str, Any]) -> dict[str, Any]:
    """What is known of a stage when it starts, for ``Recorder``."""
    home = repository_root()
    tags = {
        "dvc.stage": stage,
        "dvc.lock_hash": origin.fingerprint,
        "dvc.experiment": os.environ.get("DVC_EXP_NAME"),
        "dvc.baseline": os.environ.get("DVC_EXP_BASELINE_REV"),
        "mlflow.source.name": origin.command,
        "mlflow.source.git.commit": git_commit(home),
    }
    own = os.environ.get("MLFLOW_TRACKING_URI")
    return {
        "stage": stage,
        "store": own or store_uri(home),
        "lock": str(home / "mlflow.db.lock"),
        "artifacts": None if own else (home / "mlartifacts").as_uri(),
        "reproduction": reproduction(),
        "time": now(),
        "params": params,
        "tags": {name: value for name, value in tags.items() if value},
    }


def store_uri(home: Path) -> str:
    """The MLflow store of the repository at ``home``."""
    return f"sqlite:///{home / 'mlflow.db'}"


def reproduction() -> str | None:
    """What makes the stages of one ``dvc repro`` or experiment one: the DVC process above them.

    None for a stage that was started by hand.
    """
    for process in psutil.Process().parents():
        known = process.as_dict(["pid", "cmdline", "create_time"])  # None for what is not allowed
        if any(Path(word).stem == "dvc" for word in (known["cmdline"] or [])[:3]):
            return f"{known['pid']}-{known['create_time']:.0f}"
    return None


def now() -> int:
    """The time as MLflow counts it, in ms."""
    return round(time.time() * 1000)
