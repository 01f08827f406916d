"""All results are made once by a commit, in their order, and a killed run goes on."""

from dataclasses import replace
from pathlib import Path

import pytest

from rallygap.pipeline.experiments import everything
from rallygap.pipeline.experiments.everything import STEPS, Step, make_everything, step_results
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.runtime.errors import InputError
from tests.clone import commit, run


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A repository with three steps, each of which notes that it ran."""
    run(tmp_path, "git", "init", "--quiet")
    for package in ("models/ball", "models/robot"):
        (tmp_path / package).mkdir(parents=True)
        (tmp_path / package / "code.py").write_text("1")
    (tmp_path / "dvc.yaml").write_text("stages: {segment: {}}")
    commit(tmp_path, "code")
    steps = [Step(name, (f"bash -c 'echo {name} >> ran'",), 1) for name in ("a", "b", "c")]
    monkeypatch.setattr(everything, "STEPS", steps)
    return tmp_path


def ran(root):
    """The steps that ran, in their order."""
    return (root / "ran").read_text().split() if (root / "ran").exists() else []


def test_every_step_runs_once(repository, capsys):
    make_everything(repository)
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]
    assert "b: step 2 of 3, 2 min left" in capsys.readouterr().out
    assert not any(one.is_stale for one in step_results(repository))


def test_after_a_change_of_the_code_all_run_again(repository):
    make_everything(repository)
    (repository / "models/ball/code.py").write_text("2")
    commit(repository, "change")
    assert [one.changed for one in step_results(repository)] == [("models/ball",)] * 3
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"] * 2


def test_what_a_step_does_not_import_makes_no_step_run_again(repository):
    make_everything(repository)
    (repository / "models/robot/code.py").write_text("2")
    commit(repository, "change")
    assert not any(one.is_stale for one in step_results(repository))


def test_settings_that_a_step_depends_on_make_it_run_again(repository, monkeypatch):
    steps = [replace(everything.STEPS[0], profile="quick"), *everything.STEPS[1:]]
    monkeypatch.setattr(everything, "STEPS", steps)
    make_everything(repository)
    (repository / "profiles").mkdir()
    (repository / "profiles/quick.yaml").write_text("seed: 1")
    commit(repository, "profile")
    assert [one.is_stale for one in step_results(repository)] == [True, False, False]


def test_files_that_no_module_imports_can_make_a_step_run_again(repository, monkeypatch):
    steps = [replace(everything.STEPS[0], files=("tests/faults",)), *everything.STEPS[1:]]
    monkeypatch.setattr(everything, "STEPS", steps)
    make_everything(repository)
    (repository / "tests/faults").mkdir(parents=True)
    (repository / "tests/faults/kills.py").write_text("1")
    commit(repository, "change")
    assert [one.folder.name for one in step_results(repository) if one.is_stale] == ["a"]


def test_what_has_failed_goes_on_where_it_was(repository, monkeypatch):
    whole = everything.STEPS
    monkeypatch.setattr(everything, "STEPS", [whole[0], Step("b", ("false",), 1), whole[2]])
    with pytest.raises(InputError, match="false: has failed"):
        make_everything(repository)
    assert set(read_json(repository / "reports/commits.json")) == {"a"}
    monkeypatch.setattr(everything, "STEPS", whole)
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]


def test_a_step_can_be_asked_for(repository):
    make_everything(repository, ["b"])
    assert ran(repository) == ["b"]
    with pytest.raises(InputError, match="there are a, b, c"):
        make_everything(repository, ["d"])


def test_code_that_is_not_committed_makes_no_results(repository):
    (repository / "models/ball/code.py").write_text("2")
    with pytest.raises(InputError, match="not committed"):
        make_everything(repository)
    assert ran(repository) == []


def test_new_code_that_is_not_committed_makes_no_results(repository):
    (repository / "models/ball/effect.py").write_text("3")
    with pytest.raises(InputError, match="not committed"):
        make_everything(repository)
    (repository / "models/ball/effect.py").unlink()
    steps_file = repository / "notes.txt"  # no code
    steps_file.write_text("a")
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]


def test_code_that_changes_during_a_run_ends_it(repository, monkeypatch):
    edits = Step("a", ("bash -c 'echo 2 > models/ball/code.py'",), 1)
    monkeypatch.setattr(everything, "STEPS", [edits, *everything.STEPS[1:]])
    with pytest.raises(InputError, match="not committed"):
        make_everything(repository)
    assert ran(repository) == []


def test_without_a_clone_no_results_are_made(tmp_path, monkeypatch):
    monkeypatch.setattr(everything, "STEPS", [Step("a", ("true",), 1)])
    (tmp_path / "dvc.yaml").write_text("stages: {segment: {}}")
    with pytest.raises(InputError, match="no clone"):
        make_everything(tmp_path)


def test_an_experiment_that_a_killed_step_has_run_is_not_run_again(repository, monkeypatch):
    (repository / "profiles").mkdir()
    (repository / "profiles/quick.yaml").write_text("{}")
    (repository / "params.yaml").write_text("{}")
    commit(repository, "profile")
    head = run(repository, "git", "rev-parse", "HEAD").strip()
    run(repository, "git", "update-ref", f"refs/exps/{head[:2]}/{head[2:]}/a", head)
    kept = Step("a", ("bash -c 'echo kept >> ran'",), 1, profile="quick", experiment=True)
    monkeypatch.setattr(everything, "STEPS", [kept])
    make_everything(repository)
    assert ran(repository) == ["kept"]


def test_steps_that_need_measured_sets_are_left_out_without_them(
    repository, tmp_path, monkeypatch, capsys
):
    measured = Step("d", ("bash -c 'echo d >> ran'",), 1, measured=True)
    monkeypatch.setattr(everything, "STEPS", [*everything.STEPS, measured])
    monkeypatch.delenv("RALLYGAP_DATA", raising=False)
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]
    assert "d: left out, because it needs the measured sets" in capsys.readouterr().out
    monkeypatch.setenv("RALLYGAP_DATA", str(tmp_path / "missing"))
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]
    monkeypatch.setenv("RALLYGAP_DATA", str(tmp_path))
    make_everything(repository)
    assert ran(repository)[-1] == "d"


def test_steps_have_names_of_their_own_and_settings_that_exist():
    assert len({one.name for one in STEPS}) == len(STEPS)
    profiles = Path(__file__).parents[3] / "profiles"
    for step in STEPS:
        assert any((profiles / f"{step.profile}{end}").exists() for end in ("", ".yaml"))


def test_steps_that_need_a_gpu_are_left_out_without_one(repository, monkeypatch, capsys):
    trained = Step("d", ("bash -c 'echo d >> ran'",), 1, gpu=True)
    monkeypatch.setattr(everything, "STEPS", [*everything.STEPS, trained])
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c"]
    assert "d: left out, because torch finds no GPU here" in capsys.readouterr().out
    monkeypatch.setattr("torch.cuda.is_available", lambda: True)
    make_everything(repository)
    assert ran(repository) == ["a", "b", "c", "d"]
