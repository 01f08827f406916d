"""Kept results say which commit they are of, and are stale once the code has changed."""

import pytest

from pipeline.experiments.stale import kept_result, kept_results
from pipeline.io.artifacts import write_json
from tests.clone import commit, run


@pytest.fixture
def repository(tmp_path):
    """A repository with a kept run, kept tables, a sweep and a stage's own report."""
    run(tmp_path, "git", "init", "--quiet")
    (tmp_path / "models/ball").mkdir(parents=True)
    (tmp_path / "models/ball/drag.py").write_text("1")
    commit(tmp_path, "code")
    head = run(tmp_path, "git", "rev-parse", "HEAD").strip()
    write_json(tmp_path / "reports/paper/run.json", {"commit": head})
    for name in ("exam/records.jsonl", "sweeps/policy/sweep.json", "segment/contents.json"):
        write_json(tmp_path / "reports" / name, {})
    commit(tmp_path, "results")
    return tmp_path


def test_kept_results_are_of_the_code_of_today_until_it_changes(repository):
    kept = {str(one.folder): one for one in kept_results(repository)}
    assert set(kept) == {"reports/paper", "reports/exam", "reports/sweeps/policy"}
    assert not any(one.is_stale for one in kept.values())
    (repository / "models/ball/drag.py").write_text("2")
    for one in kept_results(repository):
        assert one.is_stale
        assert one.changed == ("models/ball",)
        assert one.sentence.endswith("the code has changed since.")


def test_a_commit_that_is_not_there_counts_as_stale(repository):
    write_json(repository / "reports/paper/run.json", {"commit": 40 * "0"})
    paper = next(one for one in kept_results(repository) if one.folder.name == "paper")
    assert paper.is_stale
    assert kept_result(repository, repository / "reports/paper") == paper
    assert "which this clone does not have" in paper.sentence
