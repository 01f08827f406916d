"""Kept results say which commit they are of, and are stale once the code has changed."""

import pytest

from rallygap.pipeline.experiments.stale import changed_code, kept_modules, kept_result, result_of
from rallygap.pipeline.io.artifacts import write_json
from tests.clone import commit, run

PRESENTED = (
    "models/gap/verdict.schema.json",
    "pipeline/swap_study/figures.py",
    "pipeline/transfer/figures/code.py",
    "pipeline/web/code.py",
)


@pytest.fixture
def repository(tmp_path):
    """A repository with code and a kept run."""
    run(tmp_path, "git", "init", "--quiet")
    for file in ("models/ball/code.py", *PRESENTED):
        (tmp_path / file).parent.mkdir(parents=True)
        (tmp_path / file).write_text("1")
    (tmp_path / "dvc.yaml").write_text("stages: {segment: {}}")
    commit(tmp_path, "code")
    head = run(tmp_path, "git", "rev-parse", "HEAD").strip()
    write_json(tmp_path / "reports/paper/run.json", {"commit": head})
    commit(tmp_path, "results")
    return tmp_path


def test_kept_results_are_of_the_code_of_today_until_it_changes(repository):
    paper = repository / "reports" / "paper"
    assert not kept_result(repository, paper).is_stale
    (repository / "models/ball/code.py").write_text("2")
    kept = kept_result(repository, paper)
    assert kept.is_stale
    assert kept.changed == ("models/ball",)
    assert kept.sentence.endswith("the code has changed since.")


@pytest.mark.parametrize("file", PRESENTED)
def test_what_only_presents_results_makes_none_of_them_stale(repository, file):
    (repository / file).write_text("2")
    assert not kept_result(repository, repository / "reports" / "paper").is_stale
    assert changed_code(repository, "HEAD") == ()


def test_the_exam_makes_no_kept_run_stale(repository):
    stages = "stages: {segment: {}, hidden_effects: {}}"
    (repository / "dvc.yaml").write_text(stages)
    assert kept_modules(repository) == ["rallygap.stages.segment"]


def test_comments_and_docstrings_make_no_results_stale(repository):
    code, paper = repository / "models/ball/code.py", repository / "reports" / "paper"
    for text in ("1  # m", '"""A one."""\n\n1\n'):
        code.write_text(text)
        assert not kept_result(repository, paper).is_stale
    code.write_text('"""A one."""\n\n1.0\n')
    assert kept_result(repository, paper).is_stale
    code.unlink()
    assert kept_result(repository, paper).is_stale


def test_results_without_a_record_are_of_the_commit_that_last_changed_them(repository):
    write_json(repository / "reports/exam/records.json", {})
    commit(repository, "exam")
    head = run(repository, "git", "rev-parse", "HEAD").strip()
    assert kept_result(repository, repository / "reports" / "exam").commit == head


@pytest.mark.parametrize(
    ("missing", "sentence"),
    [
        (40 * "0", "Results of commit 0000000, which this clone does not have."),
        ("", "Results of a commit that nobody noted."),
    ],
)
def test_a_commit_that_is_not_there_counts_as_stale(repository, missing, sentence):
    found = result_of(repository, repository / "reports" / "paper", missing)
    assert found.is_stale
    assert found.sentence == sentence
