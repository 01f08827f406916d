"""Commands that need the repository, or a run in it, say so in one line where there is none."""

import pytest

from pipeline.runtime.errors import InputError
from pipeline.runtime.repository import clone, clone_with_run


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
