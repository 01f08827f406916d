"""Passwords stay where they were put, and servers listen on this machine alone."""

import os
import re

import pytest

from experiments.clone import ROOT, run
from rallygap.pipeline import cli
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking.results import Results
from rallygap.pipeline.tracking.runs import stage_start, tracked_stage, without_secrets
from tests.services import free_port

ORIGIN = Provenance("python -m rallygap.stages.segment", "f" * 64)
SECRET = "hunter2"
STORES = [
    f"http://me:{SECRET}@127.0.0.1:9",
    f"postgresql://me:{SECRET}@127.0.0.1:9/runs",
    f"postgresql://127.0.0.1:9/runs?user=me&password={SECRET}",
    f"nonsense://me:{SECRET}@127.0.0.1:9",
]


@pytest.fixture
def home(monkeypatch, tmp_path):
    """A repository in which stages run."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("store", STORES)
def test_the_warning_about_a_store_that_fails_is_without_its_password(
    monkeypatch, home, capfd, store
):
    monkeypatch.setenv("MLFLOW_TRACKING_URI", store)
    with tracked_stage("segment", ORIGIN, {"seed": 1}, Results):
        pass
    output = "".join(capfd.readouterr())
    assert "MLflow has no complete record of segment" in output
    assert SECRET not in output


@pytest.mark.parametrize("store", STORES)
def test_a_password_in_the_address_of_the_store_is_in_no_record_and_no_message(
    monkeypatch, home, store
):
    monkeypatch.setenv("MLFLOW_TRACKING_URI", store)
    assert SECRET not in str(stage_start("segment", ORIGIN, {"seed": 1}))
    message = without_secrets(f"API request to '{store}' failed, and ({store}) too: refused")
    assert SECRET not in message
    assert message.endswith("too: refused")
    assert "127.0.0.1:9" in message


def test_the_pages_of_mlflow_are_lean_and_asked_to_listen_on_loopback(monkeypatch):
    started = {}
    monkeypatch.setenv("MLFLOW_SERVER_ENABLE_JOB_EXECUTION", "")
    monkeypatch.setattr(os, "execv", lambda program, words: started.update(words=words))
    cli.ui(free_port())
    words = started["words"]
    assert words[words.index("--host") + 1] == "127.0.0.1"
    assert words[words.index("--workers") + 1] == "1"
    assert os.environ["MLFLOW_SERVER_ENABLE_JOB_EXECUTION"] == "false"


# They look for such addresses.
WATCHING = {"tests/pipeline/test_secrets.py", "tests/pipeline/test_reproduction.py"}


def tracked_texts():
    endings = (".py", ".md", ".yaml", ".toml", ".sh", "Makefile")
    for name in run(ROOT, "git", "ls-files").split():
        path = ROOT / name
        if name.endswith(endings) and name not in WATCHING and path.is_file():
            yield name, path.read_text(encoding="utf-8")


STARTS_A_SERVER = re.compile(
    r"^.*\b(?:mlflow (?:server|ui)|dask[ -](?:scheduler|worker)|optuna-dashboard"
    r"|-m http\.server)\b.*$",
    re.MULTILINE,
)


def test_no_command_line_of_the_repository_starts_a_server_for_everyone():
    """It names where it listens: loopback, or in a cluster the address of one machine."""
    for name, text in tracked_texts():
        assert not re.search(r"\b0\.0\.0\.0\b|host[=\", ]+['\"]?(?:\*|::)['\"]", text), name
        for line in STARTS_A_SERVER.findall(text):
            if "--" in line:  # a command, not a sentence about one
                message = re.search(r"127\.0\.0\.1|localhost|--host 10\.0\.0\.[12]\b", line)
                assert message, f"{name}: {line}"
