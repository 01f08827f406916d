"""The base installation diagnoses; what it lacks is named with the extra that brings it."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rallygap.models.ball.simulators import shipped

ROOT = Path(__file__).parents[2]

# Runs Python code where every package that the base installation lacks cannot be imported.
BASE_ONLY = """
import sys
from importlib.metadata import PackageNotFoundError

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ABSENT:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
"""
COMMAND_LINE = "from rallygap.pipeline.cli import main; main()"


def base_distributions():
    """Names of what `pip install -e .` installs, dependencies of dependencies included."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found, lines = set(), [("", line) for line in project["dependencies"]]
    while lines:
        extra, line = lines.pop()
        requirement = Requirement(line)
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        name = canonicalize_name(requirement.name)
        for one in {"", *requirement.extras} - {extra for known, extra in found if known == name}:
            found.add((name, one))
            lines += [(one, further) for further in requires(name) or []]
    return {name for name, _ in found} | {"rallygap"}


@pytest.fixture(scope="module")
def base_only(tmp_path_factory):
    """Run rallygap, or any code, as in the base installation."""
    base = base_distributions()
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
    """A folder of recordings flown by the literature's simulator with more drag."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    random = np.random.default_rng(0)
    simulator = shipped("literature").amended("drag", cd=0.7)
    times = np.arange(0.0, 0.6, 0.005)
    for number in range(12):
        velocity = random.normal([0.0, 6.0, 1.5], 0.5)
        state = np.array([0.0, -1.3, 0.3, *velocity, 100.0, 0.0, 0.0])
        positions = simulator.fly(state[None], times[None]).states[0, :, :3]
        rows = np.column_stack([times, positions + random.normal(0.0, 0.002, positions.shape)])
        np.savetxt(folder / f"{number:02}.csv", rows, delimiter=",", header="t,x,y,z", comments="")
    return folder


def test_the_base_installation_diagnoses_a_folder(base_only, recordings, tmp_path):
    ended = base_only(
        "diagnose", recordings, "--simulator", "literature", "--out", tmp_path / "verdict"
    )
    assert ended.returncode == 0, ended.stderr
    verdict = json.loads((tmp_path / "verdict" / "verdict.json").read_text())
    assert verdict["verdict"] != "no_gap"


def test_the_code_of_the_python_api_page_runs_as_pasted(base_only, recordings, tmp_path):
    literature = ROOT / "models" / "ball" / "simulators" / "literature.yaml"
    shutil.copy(literature, tmp_path / "simulator.yaml")
    page = (ROOT / "docs" / "python-api.md").read_text()
    code = "\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    ended = base_only(code=code, cwd=recordings.parent)
    assert ended.returncode == 0, ended.stderr
    assert "drag.cd" in ended.stdout


@pytest.mark.parametrize("words", [["sweep", "quick"], ["ui"], ["real", "."]])
def test_a_command_that_misses_its_extra_says_which(base_only, words):
    ended = base_only(*words)
    assert ended.returncode == 2
    assert "pip install -e '.[pipeline]'" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
