"""The results of an experiment are kept with all it takes to make them again."""

import json
import os
import subprocess

import pytest

from rallygap.pipeline.experiments import keep
from rallygap.pipeline.experiments.keep import keep_experiment
from rallygap.pipeline.runtime.errors import InputError

PARAMS = "seed: 1\ningest: {folder: null}\n"
CONTENTS = '{"stage": "segment", "command": "a", "fingerprint": "f00d", "items": []}'


def git(root, *words, day=1):
    """Run git as somebody, on a day."""
    command = ["git", "-c", "user.name=a", "-c", "user.email=a@example.org", *words]
    environment = {**os.environ, "GIT_COMMITTER_DATE": f"2026-01-{day:02}T00:00:00Z"}
    options = {"capture_output": True, "text": True, "check": True}
    return subprocess.run(command, cwd=root, env=environment, **options).stdout.strip()


def commit(root, files, day=1):
    """Write files, commit them, and return the commit."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    git(root, "add", ".")
    git(root, "commit", "--quiet", "--message=files", day=day)
    return git(root, "rev-parse", "HEAD")


@pytest.fixture
def repository(tmp_path):
    """A repository with a pipeline of one stage."""
    git(tmp_path, "init", "--quiet")
    pipeline = {".dvc/config": "", "dvc.yaml": "stages: {segment: {cmd: a}}"}
    commit(tmp_path, pipeline | {"params.yaml": PARAMS})
    return tmp_path


def experiment(root, params, table="table", day=2, name="warm", contents=CONTENTS):
    """Leave an experiment the way DVC does, and return the commit it started from."""
    start = git(root, "rev-parse", "HEAD")
    report = {"segment/table.csv": table, "segment/contents.json": contents}
    report = {f"reports/{name}": text for name, text in report.items()}
    changed = commit(root, report | {"params.yaml": params}, day)
    git(root, "update-ref", f"refs/exps/{start[:2]}/{start[2:]}/{name}", changed)
    git(root, "reset", "--quiet", "--hard", start)
    return start


def test_the_exam_is_left_out_because_it_is_the_same_in_all_experiments(repository):
    stages = {"dvc.yaml": "stages: {segment: {cmd: a}, hidden_effects: {cmd: b}}"}
    commit(repository, stages)
    experiment(repository, PARAMS)
    keep_experiment(repository, "warm")
    kept = repository / "reports" / "warm"
    assert json.loads((kept / "run.json").read_text())["fingerprints"] == {"segment": "f00d"}
    assert not (kept / "hidden_effects").exists()


def test_the_report_is_copied_with_the_run_that_made_it(repository):
    start = experiment(repository, "seed: 2\ningest: {folder: null, sources: [a]}")
    keep_experiment(repository, "warm")
    kept = repository / "reports" / "warm"
    assert (kept / "segment" / "table.csv").read_text() == "table"
    assert json.loads((kept / "run.json").read_text()) == {
        "experiment": "warm",
        "commit": start,
        "command": """dvc exp run -S seed=2 -S '+ingest.sources=["a"]'""",
        "fingerprints": {"segment": "f00d"},
        "params": {"seed": 2, "ingest": {"folder": None, "sources": ["a"]}},
    }


def test_the_newest_experiment_of_a_name_is_kept_and_takes_the_old_one_s_place(repository):
    experiment(repository, PARAMS, "newer", day=4)
    keep_experiment(repository, "warm")
    commit(repository, {"another": "start"}, day=3)
    experiment(repository, PARAMS, "newest", day=5)
    keep_experiment(repository, "warm")
    assert (repository / "reports" / "warm" / "segment" / "table.csv").read_text() == "newest"


def test_files_of_other_commands_stay_and_folders_of_former_stages_go(repository):
    experiment(repository, PARAMS)
    keep_experiment(repository, "warm")
    kept = repository / "reports" / "warm"
    added = {"known_answers.csv": "set,fold", "former_stage/contents.json": "{}"}
    commit(repository, {f"reports/warm/{name}": text for name, text in added.items()}, day=3)
    experiment(repository, PARAMS, "newer", day=4)
    keep_experiment(repository, "warm")
    assert (kept / "known_answers.csv").read_text() == "set,fold"
    assert (kept / "segment" / "table.csv").read_text() == "newer"
    assert not (kept / "former_stage").exists()


def test_trained_predictors_come_along_unless_they_are_too_large(repository, monkeypatch, capsys):
    monkeypatch.setattr(keep, "LARGEST_FILE", 10)
    trained = {"transformer/MODEL_CARD.md": "card", "transformer/weights.safetensors": 11 * "x"}
    trained |= {"tae/MODEL_CARD.md": "see `reports/a.csv`", "tae/weights.safetensors": 10 * "x"}
    commit(
        repository, {f"artifacts/train_predictor/{path}": text for path, text in trained.items()}
    )
    experiment(repository, "seed: 1\nsegment: {noise: 0.1}")
    keep_experiment(repository, "warm")
    kept = repository / "reports" / "warm" / "predictors"
    assert {str(path.relative_to(kept)) for path in kept.rglob("*") if path.is_file()} == {
        "tae/MODEL_CARD.md",
        "tae/weights.safetensors",
    }
    assert (kept / "tae" / "MODEL_CARD.md").read_text() == "see `reports/warm/a.csv`"
    assert "transformer is left out" in capsys.readouterr().err


def test_predictors_that_the_pipeline_trains_anyway_are_left_out(repository):
    commit(repository, {"artifacts/train_predictor/tae/MODEL_CARD.md": "card"})
    experiment(repository, PARAMS + "train_policy: {repeats: 3}")
    keep_experiment(repository, "warm")
    assert not (repository / "reports" / "warm" / "predictors").exists()


def test_an_experiment_whose_figures_are_nowhere_is_refused_and_nothing_is_written(repository):
    out = "reports/segment/figure.png"
    lock = {"cmd": "a", "outs": [{"path": out, "hash": "md5", "md5": 32 * "a", "size": 4}]}
    pipeline = {"dvc.yaml": f"stages: {{segment: {{cmd: a, outs: [{out}]}}}}"}
    commit(
        repository,
        pipeline | {"dvc.lock": json.dumps({"schema": "2.0", "stages": {"segment": lock}})},
    )
    experiment(repository, PARAMS)
    with pytest.raises(InputError, match=f"experiment warm: neither .* has {out}; `dvc exp pull`"):
        keep_experiment(repository, "warm")
    assert not (repository / "reports" / "warm").exists()


@pytest.mark.parametrize("name", ["cold", "", "*"])
def test_an_unknown_experiment_is_refused_and_nothing_is_written(repository, name):
    experiment(repository, PARAMS)
    with pytest.raises(InputError, match="there is no such experiment"):
        keep_experiment(repository, name)
    assert not (repository / "reports").exists()


def test_an_experiment_that_names_a_folder_of_this_machine_is_not_kept(repository):
    experiment(repository, "ingest: {folder: /home/me/balls}")
    with pytest.raises(InputError, match=r"ingest\.folder: names a folder of this machine"):
        keep_experiment(repository, "warm")
    assert not (repository / "reports").exists()


@pytest.mark.parametrize("contents", ["{}", "7"])
def test_an_experiment_with_a_broken_report_is_refused_and_nothing_is_written(repository, contents):
    experiment(repository, PARAMS, contents=contents)
    with pytest.raises(InputError, match=r"segment/contents\.json"):
        keep_experiment(repository, "warm")
    assert not (repository / "reports" / "warm").exists()


@pytest.mark.parametrize(
    ("name", "says"),
    [("segment", "has the name of a stage"), ("costs", "would take the place of reports/costs")],
)
def test_an_experiment_does_not_take_the_place_of_what_was_not_kept(repository, name, says):
    commit(repository, {f"reports/{name}/table.csv": "predictor"})
    experiment(repository, PARAMS, name=name)
    with pytest.raises(InputError, match=f"experiment {name}: {says}"):
        keep_experiment(repository, name)
    assert (repository / "reports" / name / "table.csv").read_text() == "predictor"
