"""Messages: an error of input is one line, and a table in a file is complete."""

import pickle

import pytest
from rich.table import Table

from rallygap.pipeline.params import ParameterError
from rallygap.pipeline.runtime.console import show
from rallygap.pipeline.runtime.errors import InputError

ERROR = InputError("balls.csv", "is not a number", row=3, field="px")


@pytest.mark.parametrize("error", [ERROR, ParameterError([ERROR, InputError("params.yaml", "?")])])
def test_an_error_comes_whole_out_of_a_worker(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_a_table_in_a_pipe_is_as_wide_as_it_is(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    table = Table("predictor", "mean error")
    table.add_row("amended_imperfect_c", "0.519 (0.384–0.684)")
    show(table)
    assert "amended_imperfect_c │ 0.519 (0.384–0.684)" in capsys.readouterr().out
