"""A stage runs alone, stops on a signal, and names what a disk refuses."""

import errno
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import psutil
import pytest

from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.guard import guarded

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def program(text, folder, **streams):
    """Start a program in a folder."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", text]
    return subprocess.Popen(command, cwd=folder, env=environment, text=True, **streams)


def test_a_second_run_of_a_stage_waits_for_the_first_and_not_for_a_killed_one(
    folder, monkeypatch, capsys
):
    first = program(
        "from rallygap.pipeline.runtime.guard import guarded\n"
        "with guarded('segment'): print('in', flush=True); input(); open('ended', 'w')",
        folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    assert first.stdout.readline() == "in\n"
    with guarded("ingest"):  # another stage does not
        pass
    ending = threading.Timer(0.3, lambda: first.communicate("\n"))

    def warned(message):  # the first ends a little after the second has seen it
        warn(message)
        ending.start()

    monkeypatch.setattr("rallygap.pipeline.runtime.guard.warn", warned)
    with guarded("segment"):
        assert (folder / "ended").exists()
    ending.join()
    assert "another run of segment is at work here" in capsys.readouterr().err
    killed = program(KILLED, folder)
    assert killed.wait() == -signal.SIGKILL
    with guarded("segment"):
        assert capsys.readouterr().err == ""  # nobody is waited for


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES])
def test_what_a_disk_refuses_is_one_line_with_the_file(number):
    with (
        pytest.raises(InputError, match=r"^balls\.parquet: (the disk|the quota|this user)"),
        guarded("segment"),
    ):
        raise OSError(number, os.strerror(number), "balls.parquet")
    with pytest.raises(FileNotFoundError), guarded("segment"):  # others are not hidden
        raise FileNotFoundError(errno.ENOENT, "none", "balls.parquet")


KILLED = """
import os, signal
from rallygap.pipeline.runtime.guard import guarded
with guarded("segment"): os.kill(os.getpid(), signal.SIGKILL)
"""
AT_WORK = """
import time
from joblib import Parallel, delayed
from rallygap.pipeline.runtime.guard import guarded
with guarded("segment"):
    parallel = Parallel(2, return_as="generator", max_nbytes=None)
    for _ in parallel(delayed(time.sleep)(seconds) for seconds in (0, 60, 60)):
        print("at work", flush=True)
"""


def test_a_stop_signal_unwinds_the_stage_and_ends_the_workers_too(folder):
    before = signal.getsignal(signal.SIGTERM)
    with guarded("ingest"):
        assert signal.getsignal(signal.SIGTERM) != before
    assert signal.getsignal(signal.SIGTERM) == before
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    stage = program(AT_WORK, folder, **streams)
    assert stage.stdout.readline() == "at work\n"
    workers = psutil.Process(stage.pid).children(recursive=True)
    assert len(workers) >= 2
    stage.terminate()
    assert stage.wait() == 128 + signal.SIGTERM
    _, left = psutil.wait_procs(workers, timeout=20)
    assert left == []
