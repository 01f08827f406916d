"""The command line says what it does, quickly, and what is wrong in one line."""

import shutil
import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from subprocess import DEVNULL

import pytest

from tests.services import free_port, listening

ROOT = Path(__file__).parents[2]
RALLYGAP = [sys.executable, "-c", "from pipeline.cli import main; main()"]


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
        "import sys; from pipeline.cli import app\n"
        "from typer.testing import CliRunner\n"
        "print(CliRunner().invoke(app, ['--help']).output)\n"
        "heavy = {'pandas', 'mlflow', 'dvc', 'matplotlib', 'numba', 'optuna', 'torch'}\n"
        "print('loaded', heavy & set(sys.modules))"
    )
    shown = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True)
    reading = ("check", "profile", "effects", "paper", "diagnose", "costs", "run-of", "ui")
    for verb in (*reading, "real", "keep", "mend", "sweep", "confirm"):
        assert f" {verb} " in shown.stdout
    assert "loaded set()" in shown.stdout


def test_a_profile_is_printed_as_flags_from_any_folder_of_the_repository():
    shown = rallygap("profile", "real", cwd=ROOT / "models")
    assert shown.stdout.startswith('-S ingest.sources=["arena","spindoe",')
    assert shown.stderr == ""


def test_check_accepts_what_is_right_and_names_what_is_not(elsewhere):
    assert rallygap("check", cwd=elsewhere).returncode == 0
    params = elsewhere / "params.yaml"
    params.write_text(params.read_text().replace("longest_gap: 0.1", "longest_gap: long"))
    refused = rallygap("check", cwd=elsewhere)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"rallygap: {params}, segment.longest_gap: input should be")
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "says"), [(["none"], "is not a folder"), ([], "say where the measured sets are")]
)
def test_a_missing_folder_of_measured_sets_is_refused(elsewhere, words, says):
    refused = rallygap("real", *words, cwd=elsewhere)
    assert refused.returncode == 2
    assert says in refused.stderr
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.slow
def test_the_pages_of_mlflow_are_served_on_this_machine_only(elsewhere):
    port = free_port()
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    command = [*RALLYGAP, "ui", "--port", str(port)]
    with subprocess.Popen(command, cwd=elsewhere, env=environment, stderr=DEVNULL) as server:
        try:
            page = fetched(f"http://127.0.0.1:{port}/")
            assert listening(server) == {"127.0.0.1"}
        finally:
            server.terminate()
    assert b"MLflow" in page
    assert (elsewhere / "mlflow.db").exists()


def fetched(address):
    deadline = time.monotonic() + 60
    while True:
        try:
            with urllib.request.urlopen(address) as answer:
                return answer.read()
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.2)
