"""A folder that cannot be written to is refused by name."""

import os

import pytest

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_folder


def test_a_folder_that_is_there_or_can_be_made_is_accepted_but_not_somebody_elses(
    tmp_path, monkeypatch
):
    check_folder(tmp_path)
    check_folder(tmp_path / "new" / "newer")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)
    with pytest.raises(InputError, match="verdict: cannot be written to by this user"):
        check_folder(tmp_path / "verdict")
