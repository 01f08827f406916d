"""A missing repository, and a folder that cannot be written to, are refused by name."""

import os

import pytest

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_folder, clone, clone_with_run


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A clone on which nothing has run; the user stands in a folder of it."""
    monkeypatch.delenv("DVC_ROOT", raising=False)
    for name in ("pyproject.toml", "params.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "docs").mkdir()
    monkeypatch.chdir(tmp_path / "docs")
    return tmp_path


def test_the_clone_is_found_from_any_folder_of_it_and_says_how_to_run_it(home):
    assert clone() == home
    with pytest.raises(InputError, match=r"artifacts: is missing.*`make reproduce`"):
        clone_with_run()
    (home / "artifacts").mkdir()
    assert clone_with_run() == home


def test_a_folder_that_is_there_or_can_be_made_is_accepted_but_not_somebody_elses(
    tmp_path, monkeypatch
):
    check_folder(tmp_path)
    check_folder(tmp_path / "new" / "newer")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)
    with pytest.raises(InputError, match="verdict: cannot be written to by this user"):
        check_folder(tmp_path / "verdict")
