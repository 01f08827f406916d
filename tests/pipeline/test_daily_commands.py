"""The commands of docs/daily.md work one after the other, from a first run to a colleague."""

import os
import re
import shlex
import signal
import subprocess
from contextlib import contextmanager, suppress
from types import SimpleNamespace

import pytest

from experiments.clone import ROOT, environment, run, small_clone
from rallygap.pipeline.params import read_yaml
from tests.services import await_answer, free_port

pytestmark = pytest.mark.slow

PAGE = ROOT / "docs" / "daily.md"
OWN_REPOSITORY, MOUNTED = "git@git.example.org:me/rallygap.git", "/mnt/lab/rallygap"
COMMITTED = "git add . && git commit --quiet --message=run"
CHANGED = "score_segmentation"

# What `make` would install: this environment, and our command, whose pages get a free port.
ACTIVATE = 'PATH="$PWD/.venv/bin:$PATH"\n'
RALLYGAP = """#!/bin/sh
[ "$1" = ui ] && set -- ui --port {port}
exec python -c "from rallygap.pipeline.cli import main; main()" "$@"
"""


def commands(heading):
    """The lines of the first block of commands under a heading of the page."""
    pattern = rf"^#+ {heading}\n.*?```bash\n(.*?)```"
    found = re.search(pattern, PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return found[1].splitlines()


@pytest.fixture(scope="module")
def day(tmp_path_factory):
    """A repository after the commands, while its pages are still served."""
    home = tmp_path_factory.mktemp("day")
    mine, own, lab = home / "mine", home / "own.git", home / "lab"
    small_clone(mine)
    run(home, "git", "init", "--quiet", "--bare", "--initial-branch=main", str(own))
    port = free_port()
    environment_of(mine, port)
    places = {OWN_REPOSITORY: own, MOUNTED: lab}
    first, *others = (placed(line, places) for line in commands("From a run to a shared result"))
    # Results of parameters as small as these are not committed.
    with entered(mine, [first, COMMITTED, *others]):
        yield SimpleNamespace(mine=mine, places=places, port=port)


def placed(line, places):
    """A command with places of this test in place of the page's."""
    for name, path in places.items():
        line = line.replace(name, shlex.quote(str(path)))
    return line


def environment_of(folder, port):
    """Set up an environment that `make` takes for ready."""
    programs = folder / ".venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "activate").write_text(ACTIVATE)
    (programs / "rallygap").write_text(RALLYGAP.format(port=port))
    (programs / "rallygap").chmod(0o755)
    (folder / ".venv" / "ready").touch()


@contextmanager
def entered(folder, lines):
    """Enter lines into one shell, up to the first that fails; kill what it leaves running."""
    log, script = folder.with_name("log"), "\n".join(lines)
    with log.open("w") as output:
        shell = subprocess.Popen(
            ["bash", "-evc", script], cwd=folder, env=environment(folder),
            stdout=output, stderr=output, start_new_session=True,
        )  # fmt: skip
    try:
        assert shell.wait() == 0, log.read_text()
        yield
    finally:
        with suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)


def test_what_is_committed_stays_whole(day):
    changes = run(day.mine, "git", "status", "--porcelain").splitlines()
    assert [line for line in changes if not line.startswith("?? reports/sweeps/")] == []
    assert "up to date" in run(day.mine, "dvc", "repro")


def test_all_runs_are_served(day):
    await_answer(f"http://127.0.0.1:{day.port}/health")


def test_colleagues_get_the_experiment_with_its_figures(day, tmp_path):
    lines = [placed(line, day.places) for line in commands("What the colleague types")]
    with entered(tmp_path, lines):
        pass
    theirs = tmp_path / "rallygap"
    assert read_yaml(theirs / "params.yaml")["segment"]["outlier_cost"] == 9.0
    assert list((theirs / "reports" / CHANGED / "figures").iterdir())
    assert "up to date" in run(theirs, "dvc", "repro", CHANGED)
