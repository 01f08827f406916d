"""The parts of the repository fit together: names, dependencies, versions."""

import re
import tomllib
from importlib.metadata import version
from itertools import chain
from pathlib import Path

import pytest

from rallygap.pipeline.experiments.imports import imported_packages
from rallygap.pipeline.params import Params, read_yaml

ROOT = Path(__file__).parents[1]
PIPELINE = read_yaml(ROOT / "dvc.yaml")
STAGES = list(PIPELINE["stages"])


def outputs(stage):
    """Path to whether DVC keeps it, of a stage's outputs."""
    outs = PIPELINE["stages"][stage]["outs"]
    listed = [out if isinstance(out, dict) else {out: {}} for out in outs]
    return {path: flags.get("cache", True) for out in listed for path, flags in out.items()}


def packages_of(stage):
    """Folders of the packages whose modules a stage imports, directly or not."""
    return imported_packages([f"rallygap.stages.{stage}"]) - {f"stages/{stage}"}


def test_a_stage_has_one_name_in_four_places():
    scripts = {path.stem for path in (ROOT / "stages").glob("*.py")} - {"__init__"}
    groups = set(Params.model_fields) - {"seed"}
    assert set(STAGES) == scripts == groups
    for stage in STAGES:
        entry = PIPELINE["stages"][stage]
        assert entry["cmd"] == f"python -m rallygap.stages.{stage}"
        assert entry["params"] == ["seed", stage]
        assert f"reports/{stage}/contents.json" in outputs(stage)


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_depends_on_the_packages_that_it_imports(stage):
    dependencies = PIPELINE["stages"][stage]["deps"]
    code = {path for path in dependencies if path.startswith(("models/", "pipeline/"))}
    assert f"stages/{stage}.py" in dependencies
    assert code == packages_of(stage)


def test_every_dependency_is_there_or_is_made_by_a_stage():
    made = {Path(path) for stage in STAGES for path in outputs(stage)}
    made |= {folder for path in made for folder in path.parents}
    for stage in STAGES:
        paths = [Path(path) for path in PIPELINE["stages"][stage]["deps"]]
        missing = [path for path in paths if not (made & {path, *path.parents})]
        assert [str(path) for path in missing if not (ROOT / path).exists()] == []


def test_the_report_depends_on_the_reports_of_all_other_stages():
    folders = {f"reports/{stage}" for stage in STAGES} - {"reports/report"}
    assert folders <= set(PIPELINE["stages"]["report"]["deps"])


def test_git_keeps_what_is_small_and_dvc_the_rest():
    for stage in STAGES:
        small = {path for path, dvc_keeps in outputs(stage).items() if not dvc_keeps}
        assert all(path.endswith((".json", ".csv")) for path in small)


@pytest.mark.parametrize(("shown", "name"), [("metrics", "metrics.json"), ("plots", "figures")])
def test_dvc_shows_every_stage_s_metrics_and_figures(shown, name):
    written = [path for stage in STAGES for path in outputs(stage) if Path(path).name == name]
    assert PIPELINE[shown] == written


def test_what_is_installed_has_the_exact_versions_of_the_constraints():
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = dict(line.split("==") for line in lines if not line.startswith("#"))
    versions = {canonical(name): number for name, number in pinned.items()}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for requirement in chain(project["dependencies"], *project["optional-dependencies"].values()):
        name = re.match(r"[\w.-]+", requirement)[0]
        if name == project["name"]:  # an extra that has others
            continue
        installed = version(name).split("+")[0]  # +cpu: the same version, built for less
        assert installed == versions[canonical(name)]


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()
