"""The parts of the repository fit together: names, dependencies, versions."""

import re
import tomllib
from functools import cache
from importlib.metadata import version
from itertools import chain
from pathlib import Path

import grimp
import pytest

from experiments.stages.report_experiments import EXPERIMENTS
from rallygap.pipeline.params import Params, read_yaml
from rallygap.pipeline.report.stages import PIPELINE
from tests.stage_files import outputs, paths

ROOT = Path(__file__).parents[1]
STAGES = read_yaml(ROOT / "dvc.yaml")["stages"]
LONG = read_yaml(ROOT / "experiments" / "dvc.yaml")["stages"]
ALL = STAGES | LONG
REPORTS = {"report", "report_experiments"}
# What every stage runs in but what does not shape results.
NO_RESULTS = ("rallygap.pipeline.params", "rallygap.pipeline.runtime", "rallygap.pipeline.tracking")
CODE = ("experiments", "models", "pipeline")
PRESENTATION = {"pipeline/report", "pipeline/web", "docs"}


def covers(path, file):
    return file == path or file.startswith(f"{path}/")


@cache
def import_graph():
    return grimp.build_graph("experiments", "rallygap")


def module_of(stage):
    return f"{'rallygap' if stage in STAGES else 'experiments'}.stages.{stage}"


def imported_files(stage):
    """The modules that a stage imports, directly or not, as paths; a package is all its modules."""
    graph, reached, todo = import_graph(), set(), [module_of(stage)]
    while todo:
        module = todo.pop()
        if module in reached or module.startswith(NO_RESULTS):
            continue
        reached.add(module)
        todo += graph.find_modules_directly_imported_by(module)
        todo += graph.find_children(module)
    names = (module.removeprefix("rallygap.").replace(".", "/") for module in reached)
    return {f"{name}.py" for name in names if (ROOT / f"{name}.py").is_file()}


def test_a_stage_has_one_name_for_script_parameters_and_report():
    folders = (ROOT / "stages", ROOT / "experiments" / "stages")
    scripts = {path.stem for folder in folders for path in folder.glob("*.py")} - {"__init__"}
    assert set(ALL) - scripts == {"benchmarks", "sweep"}
    assert set(STAGES) == (set(Params.model_fields) - {"seed", "cores", "exam"})
    assert set(PIPELINE) == set(STAGES) - REPORTS
    assert set(EXPERIMENTS) <= set(LONG)
    for name in scripts:
        assert ALL[name]["cmd"].startswith(f"python -m {module_of(name)}")


@pytest.mark.parametrize("name", sorted(set(PIPELINE) | set(EXPERIMENTS) | REPORTS))
def test_a_stage_depends_on_what_it_imports(name):
    script = module_of(name).removeprefix("rallygap.").replace(".", "/") + ".py"
    listed = [path for path in paths(ALL[name]["deps"]) if not path.endswith(".yaml")]
    code = [path for path in listed if path.startswith(CODE) and path != script]
    imported = {file for file in imported_files(name) if file.startswith(CODE)} - {script}
    assert script in listed
    assert sorted(file for file in imported if not any(covers(path, file) for path in code)) == []
    assert [path for path in code if not any(covers(path, file) for file in imported)] == []
    for path in code:
        modules = {str(file.relative_to(ROOT)) for file in (ROOT / path).rglob("[!_]*.py")}
        assert 2 * len(modules & imported) >= len(modules), f"list the files of {path}"


@pytest.mark.parametrize("name", sorted(set(STAGES) - REPORTS))
def test_no_computation_depends_on_captions_colours_or_pages(name):
    assert not [
        path
        for path in paths(STAGES[name]["deps"])
        if any(covers(shown, path) or covers(path, shown) for shown in PRESENTATION)
    ]


@pytest.mark.parametrize(
    "file", ["pipeline/report/sim2real.py", "pipeline/web/figure_style.py", "docs/method.md"]
)
def test_a_caption_a_colour_and_a_page_re_run_reports_alone(file):
    assert (ROOT / file).is_file()
    again = {
        name
        for name, stage in STAGES.items()
        if any(covers(path, file) for path in paths(stage["deps"]))
    }
    assert again == (set() if file.startswith("docs/") else {"report"})


def test_every_dependency_is_there_or_is_made_by_a_stage():
    made = {Path(path) for stage in ALL.values() for path in paths(outputs(stage))}
    made |= {folder for path in made for folder in path.parents}
    for stage in ALL.values():
        needed = [Path(path) for path in paths(stage["deps"]) if "${" not in path]
        missing = [path for path in needed if not (made & {path, *path.parents})]
        assert [str(path) for path in missing if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("name", sorted(set(STAGES) - REPORTS))
def test_the_run_cache_can_restore_a_computation(name):
    """DVC's run cache leaves out a stage with an uncached output that is no metric and no plot."""
    assert all(isinstance(out, str) for out in STAGES[name]["outs"])
    assert STAGES[name]["metrics"] == [{f"reports/{name}/metrics.json": {"cache": False}}]


def test_no_result_of_experiments_is_checked_out_from_a_cache_that_may_lack_it():
    for out in chain(*map(outputs, LONG.values())):
        assert [settings["cache"] for settings in out.values()] == [False]


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
