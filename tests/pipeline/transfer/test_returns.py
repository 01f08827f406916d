"""Trials with the states of their returns: all there, or one error names what is missing."""

import numpy as np
import pytest

from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.transfer.returns import AFTER, LANDED, read_played
from tests.pipeline.returned import trials

PLAYED = trials()


def test_returns_and_they_alone_have_states():
    known = PLAYED[[*AFTER, *LANDED]].notna()
    assert PLAYED["returned"].any() and not PLAYED["returned"].all()
    assert (known.all(axis=1) == PLAYED["returned"]).all()
    assert (known.any(axis=1) == PLAYED["returned"]).all()
    back = PLAYED[PLAYED["returned"]]
    speeds = np.linalg.norm(back[AFTER[3:6]], axis=1)
    assert speeds == pytest.approx(back["speed"].to_numpy())


def test_trials_come_back_from_a_file(tmp_path):
    write_table(tmp_path / "played.parquet", PLAYED)
    assert read_played(tmp_path / "played.parquet").equals(PLAYED)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns="landed_vz"), "landed_vz.*is missing"),
        (lambda table: table.assign(after_wx=np.nan), "a return lacks a value"),
        (lambda table: table.assign(ball=-1), "row 1.*ball"),
    ],
)
def test_a_broken_table_is_one_error(tmp_path, change, message):
    write_table(tmp_path / "played.parquet", change(PLAYED))
    with pytest.raises(InputError, match=message):
        read_played(tmp_path / "played.parquet")
