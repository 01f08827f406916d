"""A missing repository, and a folder that cannot be written to, are refused by name."""

import os

import pytest

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_file, check_folder, clone, clone_with_run


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A clone on which nothing has run; the user stands in a folder of it."""
    monkeypatch.delenv("DVC_ROOT", raising=False)
    for name in ("pyproject.toml", "params.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "docs").mkdir()
    monkeypatch.chdir(tmp_path / "docs")
    return tmp_path


def test_the_clone_is_found_from_any_folder_of_it(home):
    assert clone() == home


def test_another_folder_is_refused_by_its_name(home):
    (home / "params.yaml").unlink()
    with pytest.raises(InputError, match="is not within a clone of rallygap"):
        clone()


def test_a_clone_on_which_nothing_has_run_says_how_to_run_it(home):
    with pytest.raises(InputError, match=r"artifacts: is missing.*`make reproduce`"):
        clone_with_run()
    (home / "artifacts").mkdir()
    assert clone_with_run() == home


def test_a_folder_that_is_there_or_can_be_made_is_accepted(tmp_path):
    check_folder(tmp_path)
    check_folder(tmp_path / "new" / "newer")
    check_file(tmp_path / "new" / "scores.json")
    assert list(tmp_path.iterdir()) == []


def test_what_is_a_file_or_below_one_is_refused_by_the_file(tmp_path):
    notes = tmp_path / "notes.txt"
    notes.touch()
    for folder in (notes, notes / "verdict"):
        with pytest.raises(InputError, match=r"notes\.txt: is a file; give a folder"):
            check_folder(folder)
    with pytest.raises(InputError, match=r"notes\.txt: is a file; give a folder"):
        check_file(notes / "scores.json")


def test_a_folder_in_place_of_a_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="is a folder; give a file"):
        check_file(tmp_path)


def test_a_folder_of_somebody_else_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)
    with pytest.raises(InputError, match="verdict: cannot be written to by this user"):
        check_folder(tmp_path / "verdict")
