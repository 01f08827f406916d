"""The command line says what it does, quickly, and what is wrong in one line."""

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path
from subprocess import DEVNULL

import pytest

from tests.services import await_answer, free_port, listening

ROOT = Path(__file__).parents[2]
RALLYGAP = [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()"]


VERBS = "diagnose audit export live simulators example check profile ui sweep confirm benchmark"


def rallygap(*words, cwd=ROOT):
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(cwd)}
    return subprocess.run(
        [*RALLYGAP, *words], cwd=cwd, env=environment, capture_output=True, text=True
    )


@pytest.fixture
def elsewhere(tmp_path):
    """A repository of its own, with parameters and a project file."""
    shutil.copy(ROOT / "params.yaml", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_help_names_every_verb_without_loading_the_libraries():
    script = (
        "import sys; from rallygap.pipeline.cli import app\n"
        "from typer.testing import CliRunner\n"
        "print(CliRunner().invoke(app, ['--help']).output)\n"
        "heavy = {'numpy', 'pandas', 'mlflow', 'dvc', 'matplotlib', 'numba', 'optuna', 'torch'}\n"
        "print('loaded', heavy & set(sys.modules))"
    )
    shown = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True)
    for verb in VERBS.split():
        assert f" {verb} " in shown.stdout
    assert "loaded set()" in shown.stdout


def test_the_example_recordings_are_written_into_a_new_folder_only(tmp_path):
    assert rallygap("example", "recordings", cwd=tmp_path).returncode == 0
    assert len(list((tmp_path / "recordings").glob("*.csv"))) == 30
    refused = rallygap("example", "recordings", cwd=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr == "rallygap: recordings: is there already; give a new folder\n"


def test_a_profile_is_printed_as_flags_from_any_folder_of_the_repository():
    shown = rallygap("profile", "real", cwd=ROOT / "models")
    assert shown.stdout.startswith('-S ingest.sources=["arena","spindoe",')
    assert shown.stderr == ""


def test_check_accepts_what_is_right_and_names_what_is_not(elsewhere):
    accepted = rallygap("check", cwd=elsewhere)
    assert (accepted.returncode, accepted.stderr) == (0, "")
    assert "params.yaml is in order" in accepted.stdout
    params = elsewhere / "params.yaml"
    params.write_text(params.read_text().replace("longest_gap: 0.1", "longest_gap: long"))
    refused = rallygap("check", cwd=elsewhere)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"rallygap: {params}, segment.longest_gap: input should be")
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.parametrize("words", ["sweep quick", "ui"])
def test_outside_a_clone_one_line_says_so_and_nothing_is_left(tmp_path, words):
    refused = rallygap(*words.split(), cwd=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"rallygap: {tmp_path}: is not within a clone of rallygap")
    assert len(refused.stderr.splitlines()) == 1
    assert list(tmp_path.glob("[!.]*")) == []  # libraries keep caches in this home


def test_where_nothing_has_run_what_needs_a_run_says_how_to_run(elsewhere):
    refused = rallygap("benchmark", "export", "windows", cwd=elsewhere)
    assert refused.returncode == 2
    assert "artifacts: is missing, because nothing has run here" in refused.stderr
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_one_line(unbuffered):
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    command = [*RALLYGAP, "simulators"]
    with Path("/dev/full").open("w") as full:
        finished = subprocess.run(
            command, cwd=ROOT, env=environment, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert finished.returncode == 2
    assert finished.stderr.startswith("rallygap: output: the disk is full")
    assert len(finished.stderr.splitlines()) == 1


@pytest.mark.parametrize("port", ["0", "65536"])
def test_a_port_that_is_none_is_refused(elsewhere, port):
    refused = rallygap("ui", "--port", port, cwd=elsewhere)
    assert refused.returncode == 2
    assert "--port" in refused.stderr


def test_a_port_that_is_taken_is_one_line(elsewhere):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        refused = rallygap("ui", "--port", str(port), cwd=elsewhere)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"rallygap: --port: {port} cannot be had")
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.slow
def test_the_pages_of_mlflow_are_served_on_this_machine_only(elsewhere):
    port = free_port()
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    command = [*RALLYGAP, "ui", "--port", str(port)]
    with subprocess.Popen(command, cwd=elsewhere, env=environment, stderr=DEVNULL) as server:
        try:
            page = await_answer(f"http://127.0.0.1:{port}/")
            assert listening(server.pid) == {"127.0.0.1"}
        finally:
            server.terminate()
    assert b"MLflow" in page
    assert (elsewhere / "mlflow.db").exists()
