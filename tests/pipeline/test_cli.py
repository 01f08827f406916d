"""The command line says what it does, quickly, and what is wrong in one line."""

import os
import re
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from rallygap.pipeline.cli import main
from tests.pipeline.runs import served_pages
from tests.services import await_answer, listening

ROOT = Path(__file__).parents[2]
RALLYGAP = [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()"]


@pytest.fixture
def rallygap(monkeypatch, capfd):
    """Runs the command line in this process: words and a folder to status, output and errors."""

    def run(*words, cwd=ROOT):
        monkeypatch.chdir(cwd)
        monkeypatch.setattr(sys, "argv", ["rallygap", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code or 0, *capfd.readouterr()

    return run


@pytest.fixture
def elsewhere(tmp_path):
    """A repository of its own, with parameters and a project file."""
    shutil.copy(ROOT / "params.yaml", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_help_is_shown_without_loading_the_libraries():
    script = (
        "import sys; from rallygap.pipeline.cli import app\n"
        "from typer.testing import CliRunner\n"
        "print(CliRunner().invoke(app, ['--help']).output)\n"
        "heavy = {'numpy', 'pandas', 'mlflow', 'dvc', 'matplotlib', 'numba', 'optuna', 'torch'}\n"
        "print('loaded', heavy & set(sys.modules))"
    )
    shown = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True)
    assert " diagnose " in shown.stdout
    assert "loaded set()" in shown.stdout


def test_the_example_recordings_are_written_into_a_new_folder_only(rallygap, tmp_path):
    assert rallygap("example", "recordings", cwd=tmp_path)[0] == 0
    assert len(list((tmp_path / "recordings").glob("*.csv"))) == 30
    refused = (2, "", "rallygap: recordings: is there already; give a new folder\n")
    assert rallygap("example", "recordings", cwd=tmp_path) == refused


def test_what_cannot_be_done_is_refused_in_one_line(rallygap, elsewhere):
    (elsewhere / "docs").mkdir()
    status, shown, errors = rallygap("check", cwd=elsewhere / "docs")
    assert (status, errors) == (0, "")
    assert "params.yaml is in order" in shown
    params = elsewhere / "params.yaml"
    params.write_text(params.read_text().replace("longest_gap: 0.1", "longest_gap: long"))
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = str(server.getsockname()[1])
        for words, says in (
            (["check"], f"{params}, segment.longest_gap: input should be"),
            (["benchmark", "export", "windows"], f"{elsewhere / 'artifacts'}: is missing, because"),
            (["ui", "--port", port], f"--port: {port} cannot be had"),
        ):
            status, _, errors = rallygap(*words, cwd=elsewhere)
            assert status == 2
            assert errors.startswith(f"rallygap: {says}")
            assert len(errors.splitlines()) == 1
    status, _, errors = rallygap("ui", "--port", "65536", cwd=elsewhere)
    assert status == 2 and "--port" in errors


@pytest.mark.parametrize("words", ["sweep quick", "ui"])
def test_outside_a_clone_one_line_says_so_and_nothing_is_left(rallygap, tmp_path, words):
    status, _, errors = rallygap(*words.split(), cwd=tmp_path)
    assert status == 2
    assert errors.startswith(f"rallygap: {tmp_path}: is not within a clone of rallygap")
    assert len(errors.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_one_line(unbuffered):
    options = {"cwd": ROOT, "env": {**os.environ, "PYTHONUNBUFFERED": unbuffered}, "text": True}
    with Path("/dev/full").open("w") as full:
        finished = subprocess.run(
            [*RALLYGAP, "simulators"], stdout=full, stderr=subprocess.PIPE, **options
        )
    assert finished.returncode == 2
    assert re.fullmatch("rallygap: output: the disk is full.*\n", finished.stderr)


@pytest.mark.slow
def test_the_pages_of_mlflow_are_served_on_this_machine_only(elsewhere):
    with served_pages(elsewhere, ROOT) as (address, server):
        assert b"MLflow" in await_answer(address)
        assert listening(server.pid) == {"127.0.0.1"}
    assert (elsewhere / "mlflow.db").exists()
