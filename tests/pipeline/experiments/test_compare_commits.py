"""Committed results of two commits compare number by number."""

import shutil

import pytest

from rallygap.pipeline.experiments.compare_commits import compare_commits
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.runtime.errors import InputError
from tests import clone
from tests.clone import run

TABLE = "set,error_mm,low\nspindoe,1.5,\ntt3d,2.5,2\n"


@pytest.fixture
def commit(tmp_path):
    """Commit files under reports/ in the place of all others, and return the commit."""
    run(tmp_path, "git", "init", "--quiet")

    def write(files):
        shutil.rmtree(tmp_path / "reports", ignore_errors=True)
        for name, text in files.items():
            write_text(tmp_path / "reports" / name, text)
        clone.commit(tmp_path, "run")
        return run(tmp_path, "git", "rev-parse", "HEAD").strip()

    return write


def test_names_may_change_and_numbers_may_not(commit, tmp_path):
    base = commit({"evaluate/errors.csv": TABLE, "evaluate/metrics.json": '{"mean": 1.5}'})
    renamed = TABLE.replace("error_mm", "position_error_mm")
    same = commit({"evaluate/position.csv": renamed, "evaluate/metrics.json": '{"average": 1.5}'})
    assert compare_commits(tmp_path, base, same) == (2, {})

    other = commit(
        {"evaluate/errors.csv": TABLE.replace("2.5", "2.6"), "gap/metrics.json": "[true]"}
    )
    count, differences = compare_commits(tmp_path, base, other)
    assert count == 1
    assert differences == {
        "reports/gap/metrics.json": "added",
        "reports/evaluate/metrics.json": "removed",
        "reports/evaluate/errors.csv": "1 of 4 numbers differ, first 2.5 -> 2.6",
    }


def test_kept_runs_do_not_count(commit, tmp_path):
    record = {"paper/run.json": '{"fingerprints": {}}'}
    base = commit({**record, "paper/evaluate/errors.csv": TABLE})
    other = commit({**record, "paper/evaluate/errors.csv": TABLE.replace("1", "2")})
    assert compare_commits(tmp_path, base, other) == (0, {})


def test_studies_that_have_a_record_count(commit, tmp_path):
    record = {"study/run.json": '{"commit": "a"}'}
    base = commit({**record, "study/errors.csv": TABLE})
    other = commit({**record, "study/errors.csv": TABLE.replace("2.5", "2.6")})
    assert list(compare_commits(tmp_path, base, other)[1]) == ["reports/study/errors.csv"]


def test_an_unknown_commit_is_refused(commit, tmp_path):
    commit({"evaluate/errors.csv": TABLE})
    with pytest.raises(InputError, match="no-such"):
        compare_commits(tmp_path, "no-such", "HEAD")
