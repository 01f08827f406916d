"""The package: what is installed and importable, and what the base installation can do."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import rallygap
from experiments.clone import run

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "recordings"

# Runs Python code where every package that the base installation lacks cannot be imported.
BASE_ONLY = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ABSENT:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
"""
COMMAND_LINE = "from rallygap.pipeline.cli import main; main()"


@pytest.fixture(scope="module")
def base_only(tmp_path_factory):
    """Run rallygap, or any code, as in the base installation."""
    base, todo = set(), ["rallygap"]
    while todo:
        base.add(name := canonicalize_name(todo.pop()))
        for requirement in map(Requirement, requires(name) or []):
            if not requirement.marker or requirement.marker.evaluate({"extra": ""}):
                todo += {canonicalize_name(requirement.name)} - base
    absent = {
        package
        for package, owners in packages_distributions().items()
        if not base & {canonicalize_name(owner) for owner in owners}
    }
    assert {"torch", "lightning", "mlflow", "dvc", "optuna", "stable_baselines3"} <= absent
    script = f"ABSENT = {sorted(absent)!r}\n{BASE_ONLY}"

    home = str(tmp_path_factory.mktemp("home"))

    def run(*words, code=COMMAND_LINE, cwd=ROOT):
        command = [sys.executable, "-c", script + code, *map(str, words)]
        environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": home}
        return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)

    return run


@pytest.fixture
def recordings(tmp_path):
    """A folder with eight of the example recordings."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    for number in range(8):
        shutil.copy(EXAMPLE / f"{number:02}.csv", folder)
    return folder


def test_the_base_installation_imports_what_its_commands_and_the_public_names_need(base_only):
    commands = ("gap.diagnose_folder", "engines.audit_folder", "engines.export.command")
    modules = ", ".join(f"rallygap.pipeline.{name}" for name in (*commands, "live.command"))
    ended = base_only(code=f"import {modules}; from rallygap import *")
    assert ended.returncode == 0, ended.stderr


@pytest.mark.slow
def test_the_code_of_the_python_api_page_runs_as_pasted(base_only, recordings):
    page = (ROOT / "docs" / "python-api.md").read_text()
    code = "\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    ended = base_only(code=code, cwd=recordings.parent)
    assert ended.returncode == 0, ended.stderr
    assert "named" in ended.stdout
    assert "drag.cd" in ended.stdout
    assert "gravity.g 9.81\n" in ended.stdout


@pytest.mark.parametrize("words", [["sweep", "quick"], ["ui"]])
def test_a_command_that_misses_its_extra_says_which(base_only, words):
    ended = base_only(*words)
    assert ended.returncode == 2
    assert "pip install 'rallygap[pipeline]'" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1


def test_importing_rallygap_loads_no_library_and_changes_nothing_in_the_process():
    code = (
        "import os, sys; before = dict(os.environ); import rallygap; lean = {*sys.modules}\n"
        "from rallygap import diagnose, Simulator, Verdict; assert before == dict(os.environ)\n"
        "print({'numpy', 'pandas', 'torch', 'rallygap.pipeline'} & lean)"
    )
    assert run(ROOT, sys.executable, "-c", code) == "set()\n"


@pytest.mark.parametrize(
    ("words", "threads"),
    [
        (["-m", "rallygap.stages.segment"], "1"),
        (["-m", "rallygap.pipeline.gap.measured_shots"], "1"),
        (["-c", COMMAND_LINE, "audit", "literature", "--out", "audit"], "1"),
        (["-c", "from rallygap import diagnose"], "None"),
    ],
)
def test_programs_hold_their_arithmetic_before_numpy_is_loaded(words, threads, tmp_path):
    numpy = "import os; print(os.environ.get('OPENBLAS_NUM_THREADS')); raise SystemExit"
    (tmp_path / "numpy.py").write_text(numpy)
    environment = {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    started = subprocess.run(
        [sys.executable, *words], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert started.stdout.split() == [threads], started.stderr


def test_the_example_recordings_are_those_that_their_script_writes(tmp_path):
    script = runpy.run_path(str(ROOT / "docs" / "examples" / "record_shots.py"))
    script["record_shots"](tmp_path / "recordings")
    written = contents(tmp_path / "recordings")
    assert len(written) == 30
    assert sum(map(len, written.values())) < 200_000
    assert written == contents(EXAMPLE)


def contents(folder):
    """The contents of the files of a folder, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder in which the wheel was built, installed in an empty environment, and tried."""
    folder = tmp_path_factory.mktemp("wheel")
    environment = {key: text for key, text in os.environ.items() if key != "PYTHONPATH"}
    environment["PYTHON"] = sys.executable
    subprocess.run([ROOT / ".ci" / "wheel", folder], env=environment, check=True)
    return folder


@pytest.mark.slow
def test_the_wheel_has_the_package_with_its_data_and_nothing_else(built):
    tracked = run(ROOT, "git", "ls-files", "models", "pipeline", "stages").split()
    recordings = (f"examples/recordings/{path.name}" for path in EXAMPLE.iterdir())
    (wheel,) = built.glob("*.whl")
    packaged = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    own = ["__init__.py", "py.typed", *recordings]
    assert packaged == {f"rallygap/{name}" for name in [*own, *tracked]}
    installed = {path.name for path in built.glob("empty/lib/python*/site-packages/*")}
    assert not {"models", "pipeline", "stages", "tests", "docs", "benchmarks"} & installed


@pytest.mark.slow
def test_the_wheel_works_in_an_empty_environment_away_from_the_repository(built):
    assert contents(built / "recordings") == contents(EXAMPLE)
    verdict = rallygap.Verdict.load(built / "verdict" / "verdict.json")
    assert [cause.identity for cause in verdict.leading] == ["drag.cd", "table_bounce.restitution"]
    assert (built / "audit" / "report.html").exists()


@pytest.fixture
def clone(tmp_path):
    """What `make` needs to set up an environment; pip does nothing there."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def make_environment(folder):
    python = folder / "python"  # which takes no seconds for a pip that does nothing here
    write_program(python, f'exec {sys.executable} "$@" --without-pip')
    command = ["make", ".venv/ready", "PIP=true", f"PYTHON={python}"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def write_program(path, line):
    path.unlink(missing_ok=True)
    path.write_text(f"#!/bin/sh\n{line}\n")
    path.chmod(0o755)


def test_make_uses_an_environment_that_it_did_not_make_but_none_of_another_python(clone):
    run(clone, sys.executable, "-m", "venv", "--without-pip", ".venv")
    (clone / ".venv" / "mine").touch()
    made = make_environment(clone)
    assert "make: the environment .venv is there already" in made.stdout
    assert (clone / ".venv" / "mine").exists()
    (clone / ".venv" / "ready").unlink()
    write_program(clone / ".venv" / "bin" / "python", "exit 1")
    made = make_environment(clone)
    assert made.returncode != 0
    assert made.stderr.startswith("make: .venv is not of Python 3.11")


def test_make_creates_again_what_it_did_not_finish(clone):
    (clone / ".venv").mkdir()
    for name in ("by-make", "half"):
        (clone / ".venv" / name).touch()
    assert make_environment(clone).returncode == 0
    assert (clone / ".venv" / "ready").exists()
    assert not (clone / ".venv" / "half").exists()
