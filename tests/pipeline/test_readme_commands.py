"""The commands of README's daily use work one after the other, as they stand there."""

import os
import re
import shlex
import signal
import subprocess
from contextlib import contextmanager, suppress
from types import SimpleNamespace

import pytest
import yaml

from pipeline.experiments.profiles import merged
from pipeline.params import read_yaml
from tests.clone import ROOT, cloned, commit, environment, run
from tests.services import await_answer, free_port

pytestmark = pytest.mark.slow

BLOCK = re.compile(r"in ten commands:\n\n```bash\n(.*?)```", re.DOTALL)
MOUNTED = "/mnt/lab/rallygap"
PUBLISHED = "git add . && git commit --quiet --message=run && git push --quiet"
CHANGED = "score_segmentation"

# What `make` would install: this environment, and our command, whose pages get a free port.
ACTIVATE = 'PATH="$PWD/.venv/bin:$PATH"\n'
RALLYGAP = """#!/bin/sh
[ "$1" = ui ] && set -- ui --port {port}
exec python -c "from pipeline.cli import main; main()" "$@"
"""


def commands():
    (block,) = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    return block.splitlines()


@pytest.fixture(scope="module")
def day(tmp_path_factory):
    """A repository after the ten commands, while its pages are still served."""
    home = tmp_path_factory.mktemp("day")
    mine, origin, lab = home / "mine", home / "origin.git", home / "lab"
    published(home / "first", origin)
    run(home, "git", "clone", "--quiet", str(origin), str(mine))
    port = free_port()
    environment_of(mine, port)
    first, *others = (line.replace(MOUNTED, shlex.quote(str(lab))) for line in commands())
    # Results of parameters as small as these are not in the README's repository.
    with entered(mine, [first, PUBLISHED, *others]):
        yield SimpleNamespace(mine=mine, origin=origin, lab=lab, port=port)


def published(folder, origin):
    """Make a repository with the smallest parameters, to be cloned from ``origin``."""
    cloned(folder)
    small = merged(read_yaml(folder / "params.yaml"), read_yaml(folder / "profiles" / "smoke.yaml"))
    (folder / "params.yaml").write_text(yaml.safe_dump(small, sort_keys=False))
    commit(folder, "small")
    run(folder, "git", "clone", "--quiet", "--bare", str(folder), str(origin))


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


def test_there_are_ten_commands_each_with_its_comment():
    assert [" # " in line for line in commands()] == [True] * 10


def test_what_is_committed_stays_whole(day):
    changes = run(day.mine, "git", "status", "--porcelain").splitlines()
    assert [line for line in changes if not line.startswith("?? reports/sweeps/")] == []
    assert "up to date" in run(day.mine, "dvc", "repro")


def test_all_runs_are_served(day):
    await_answer(f"http://127.0.0.1:{day.port}/health")


def test_colleagues_get_the_experiment_with_its_figures(day, tmp_path):
    theirs = tmp_path / "theirs"
    run(tmp_path, "git", "clone", "--quiet", str(day.origin), str(theirs))
    run(theirs, "dvc", "remote", "add", "--local", "--default", "lab", str(day.lab))
    run(theirs, "dvc", "exp", "pull", "origin", "careful")
    run(theirs, "dvc", "exp", "apply", "careful")
    assert read_yaml(theirs / "params.yaml")["segment"]["outlier_cost"] == 9.0
    assert list((theirs / "reports" / CHANGED / "figures").iterdir())
    assert "up to date" in run(theirs, "dvc", "repro", CHANGED)
