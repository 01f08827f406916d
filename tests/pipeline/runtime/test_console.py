"""A table in a file is complete, however narrow the terminal is."""

from rich.table import Table

from rallygap.pipeline.runtime.console import show


def test_a_table_in_a_pipe_is_as_wide_as_it_is(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    table = Table("predictor", "mean error")
    table.add_row("amended_imperfect_c", "0.519 (0.384–0.684)")
    show(table)
    assert "amended_imperfect_c │ 0.519 (0.384–0.684)" in capsys.readouterr().out
