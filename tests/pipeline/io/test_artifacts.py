"""Artefacts: whole or not at all, same content same bytes, one error for what cannot be read."""

from contextlib import contextmanager

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import (
    open_table,
    read_json,
    read_row_groups,
    read_table,
    replacing,
    replacing_folder,
    table_writer,
    write_json,
    write_table,
    write_text,
)
from rallygap.pipeline.runtime.errors import InputError

TABLE = pd.DataFrame({"name": ["a", "b"], "value": [0.1, np.nan], "count": [1, 2]})


def read_groups(path):
    return list(read_row_groups(path))


def count_groups(path):
    with open_table(path) as table:
        return table.num_row_groups


READERS = [read_json, read_table, read_groups, count_groups]


@contextmanager
def writing_table(path):
    with table_writer(path, TABLE.iloc[:0]) as add:
        add(TABLE.assign(name="half"))
        yield path


@pytest.mark.parametrize("writing", [replacing, replacing_folder, writing_table])
def test_what_breaks_off_leaves_the_former_and_nothing_else(tmp_path, writing):
    path = tmp_path / "former"
    if writing is replacing_folder:
        path.mkdir()
    (path / "file" if path.is_dir() else path).write_text("former")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(RuntimeError), writing(path) as temporary:
        if writing is not writing_table:
            (temporary / "part" if temporary.is_dir() else temporary).write_text("half")
        raise RuntimeError
    assert sorted(tmp_path.rglob("*")) == before
    assert (path / "file" if path.is_dir() else path).read_text() == "former"


def test_a_folder_takes_the_place_of_the_former_one(tmp_path):
    for content in ("first", "second"):
        with replacing_folder(tmp_path / "deep" / "folder") as folder:
            (folder / content).touch()
    assert [path.name for path in (tmp_path / "deep").rglob("*")] == ["folder", "second"]


def test_json_keeps_its_order_and_text_has_unix_line_ends(tmp_path):
    content = {"z": np.int64(3), "a": [np.float64(0.1), None, "ü"], "flag": np.bool_(True)}
    write_json(tmp_path / "new" / "content.json", content)
    assert list(read_json(tmp_path / "new" / "content.json").items()) == list(content.items())
    write_text(tmp_path / "text", "ä\nb\n")
    assert (tmp_path / "text").read_bytes() == "ä\nb\n".encode()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object()])
def test_what_json_cannot_say_is_not_written(tmp_path, value):
    with pytest.raises((ValueError, TypeError)):
        write_json(tmp_path / "content.json", {"value": value})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("groups", [[TABLE, TABLE.iloc[:1], TABLE.assign(name="c")], []])
def test_a_table_comes_back_in_the_groups_it_was_written_in_always_as_the_same_bytes(
    tmp_path, groups
):
    for name in ("table.parquet", "again.parquet"):
        with table_writer(tmp_path / name, TABLE.iloc[:0]) as add:
            for group in [*groups, TABLE.iloc[:0]]:
                add(group)
    path = tmp_path / "table.parquet"
    assert path.read_bytes() == (tmp_path / "again.parquet").read_bytes()
    assert count_groups(path) == len(groups)
    for read, group in zip(read_groups(path), groups, strict=True):
        pd.testing.assert_frame_equal(read, group)
    whole = pd.concat(groups, ignore_index=True) if groups else TABLE.iloc[:0]
    pd.testing.assert_frame_equal(read_table(path), whole)
    pd.testing.assert_frame_equal(read_table(path, ["count", "name"]), whole[["count", "name"]])


@pytest.mark.parametrize("reader", READERS)
def test_a_missing_file_says_what_to_run(tmp_path, reader):
    with pytest.raises(InputError, match="run the stage that writes it"):
        reader(tmp_path / "missing")
    with pytest.raises(InputError):
        reader(tmp_path)


@pytest.mark.parametrize("reader", READERS)
def test_a_broken_file_is_one_error(tmp_path, reader):
    path = tmp_path / "broken"
    write_table(path, TABLE)
    cut_short = path.read_bytes()[:-10]
    for content in (b"", b"{", b"\xff\xfe\x00", b"PAR1 and no more", b"[" * 9**5, cut_short):
        path.write_bytes(content)
        with pytest.raises(InputError, match="broken: is not"):
            reader(path)
