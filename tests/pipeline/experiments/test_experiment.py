"""Long experiments resume on the same code, publish all at once, and say where it comes from."""

import runpy

import pandas as pd
import pytest
from matplotlib.figure import Figure

from rallygap.pipeline.experiments.experiment import running
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.runtime.errors import InputError
from tests.clone import commit, run

NAME = "arenas.run"
INPUT = "artifacts/segment"
TABLE = pd.DataFrame({"error": [1.23456]})
EXPERIMENTS = {  # and code that shapes what they resume from
    "arenas.run": "pipeline/segmentation",
    "learning_curves.run": "pipeline/gap",
    "real_forecasts.run": "pipeline/sources",
    "simulator_scenes.real": "pipeline/engines",
    "simulator_scenes.run": "models/audit",
    "spread_policies.run": "pipeline/policies",
    "swap_study.run": "pipeline/evaluation",
}


class Killed(BaseException):
    """What ends a process."""


class Unfinished(Figure):
    """A figure at which a process ends."""

    def savefig(self, *_, **__):
        raise Killed


@pytest.fixture
def repository(tmp_path):
    """A repository with code, parameters and an artefact."""
    run(tmp_path, "git", "init", "--quiet")
    packages = {"models/ball", "pipeline/exam", "pipeline/web", *EXPERIMENTS.values()}
    for package in packages:
        (tmp_path / package).mkdir(parents=True)
        (tmp_path / package / "code.py").write_text("1")
    (tmp_path / "params.yaml").write_text("seed: 1")
    commit(tmp_path, "code")
    (tmp_path / INPUT).mkdir(parents=True)
    (tmp_path / INPUT / "samples.parquet").write_text("1")
    return tmp_path


def changed(root, file):
    """Change and commit a file."""
    (root / file).write_text("2")
    commit(root, "change")


def head(root):
    return run(root, "git", "rev-parse", "HEAD").strip()


def scratch_of(root, name=NAME, inputs=(INPUT,), data="spins"):
    """Where a run would leave what it computes."""
    with running(root, name, inputs, data) as one:
        return one.scratch


def publish(one, table=TABLE, figure=None):
    one.publish("arenas", {"errors": table}, {"arenas": figure or Figure()}, "run", {"seed": 7})


def reports(root):
    """The content of all reports, by name."""
    return {one.name: one.read_bytes() for one in (root / "reports").rglob("*") if one.is_file()}


def test_reports_say_where_they_come_from(repository):
    with running(repository, NAME) as one:
        publish(one)
    assert (repository / "reports/arenas/errors.csv").read_text() == "error\n1.235\n"
    record = read_json(repository / "reports/arenas/run.json")
    assert record.keys() == {"cpu", "cores", "torch", "commit", "fingerprint", "seed"}
    assert (record["commit"], record["seed"]) == (head(repository), 7)
    assert record["fingerprint"].startswith(one.scratch.name)


def test_the_recorded_commit_is_that_of_the_start(repository):
    start = head(repository)
    with running(repository, NAME) as one:
        changed(repository, "models/ball/code.py")
        publish(one)
    assert head(repository) != start
    assert read_json(repository / "reports/arenas/run.json")["commit"] == start


def test_a_killed_run_leaves_the_former_reports_whole_and_resumes(repository):
    with running(repository, NAME) as one:
        publish(one)
    former = reports(repository)
    with pytest.raises(Killed), running(repository, NAME) as killed:
        killed.scratch.mkdir(parents=True)
        (killed.scratch / "part").write_text("computed")
        publish(killed, 2 * TABLE, Unfinished())
    assert reports(repository) == former
    assert former.keys() == {"errors.csv", "arenas.png", "run.json"}
    with running(repository, NAME) as resumed:
        assert (resumed.scratch / "part").read_text() == "computed"
        publish(resumed, 2 * TABLE)
    assert reports(repository)["errors.csv"] == b"error\n2.469\n"
    assert not resumed.scratch.exists()


def test_a_run_removes_no_folder_but_its_own(repository):
    other = scratch_of(repository, data="others")
    other.mkdir(parents=True)
    with running(repository, NAME, [INPUT], "spins") as one:
        one.scratch.mkdir()
    assert other.exists() and not one.scratch.exists()


@pytest.mark.parametrize(("name", "package"), EXPERIMENTS.items())
def test_a_run_starts_afresh_on_other_code(repository, name, package):
    before = scratch_of(repository, name)
    assert scratch_of(repository, name) == before
    changed(repository, f"{package}/code.py")
    assert scratch_of(repository, name) != before


@pytest.mark.parametrize("file", ["params.yaml", f"{INPUT}/samples.parquet"])
def test_a_run_starts_afresh_on_other_settings_and_artefacts(repository, file):
    before = scratch_of(repository)
    changed(repository, file)
    assert scratch_of(repository) != before


def test_a_run_starts_afresh_on_other_data(repository):
    assert scratch_of(repository, data="spins") != scratch_of(repository, data="other spins")


@pytest.mark.parametrize("package", ["pipeline/web", "pipeline/exam"])
def test_a_run_resumes_on_other_presentation_and_on_code_that_it_does_not_import(
    repository, package
):
    before = scratch_of(repository)
    changed(repository, f"{package}/code.py")
    assert scratch_of(repository) == before


def test_a_second_run_is_refused_until_the_first_has_ended(repository):
    with running(repository, NAME):
        with pytest.raises(InputError, match="arenas: is running already"):
            scratch_of(repository)
        scratch_of(repository, "swap_study.run")
    with pytest.raises(Killed), running(repository, NAME):
        raise Killed
    scratch_of(repository)


def test_code_that_is_not_committed_makes_no_results(repository):
    (repository / "models/ball/code.py").write_text("2")
    with pytest.raises(InputError, match="not committed"), running(repository, NAME):
        pytest.fail("it ran")


def test_a_stage_that_has_not_run_is_named(repository):
    with pytest.raises(InputError, match="close_gap: is missing; `dvc repro`"):
        scratch_of(repository, inputs=("artifacts/close_gap",))


@pytest.mark.filterwarnings("ignore:.*found in sys.modules:RuntimeWarning")
@pytest.mark.parametrize("name", EXPERIMENTS)
def test_what_is_wrong_is_said_in_one_line(repository, monkeypatch, capsys, name):
    (repository / "models/ball/code.py").write_text("2")
    monkeypatch.setenv("DVC_ROOT", str(repository))
    monkeypatch.setenv("RALLYGAP_DATA", str(repository / "absent"))
    with pytest.raises(SystemExit) as ended:
        runpy.run_module(f"rallygap.pipeline.{name}", run_name="__main__")
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "not committed" in line or "is not a folder" in line
