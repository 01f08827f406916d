"""Gathering: what is refused, what stops it, and the manifest that says so."""

import hashlib

import numpy as np
import pytest

from rallygap.pipeline.io.artifacts import read_row_groups
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources import source_import
from rallygap.pipeline.sources.gather import gather
from tests.pipeline.sources.made_up import ARENA, WRITERS, lines, read, write_csv

HEADER = "t,x,y,z"
GOOD = ["0.00,0,1,0.3", "0.01,0,1,0.3", "0.02,0,1,0.3"]


def read_rows(tmp_path, *rows):
    write_csv(tmp_path, rows=[HEADER, *rows])
    return read(tmp_path, "csv")


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("0.015,0,one,0.3", "not a number"),
        ("0.015,0,nan,0.3", "not a number"),
        ("0.015,0,1e999,0.3", "not a number"),
        ("0.015,0,1", "wrong number of fields"),
        ("0.015,0,1,0.3,7", "wrong number of fields"),
        ("0.015,0,-20.001,0.3", "farther than 20 m"),
        ("0.0100001,0,1,0.3", "time repeated"),
    ],
)
def test_an_impossible_row_is_refused_and_the_rest_kept(tmp_path, row, reason):
    gathered = read_rows(tmp_path, GOOD[0], "", GOOD[1], row, "  ", GOOD[2])
    record = gathered.manifest.sources["csv"]
    assert record.rows_refused[reason].model_dump() == {"count": 1, "rows": {"session.csv": [5]}}
    assert list(record.rows_refused) == [reason]
    assert (record.rows_read, record.rows_kept) == (4, 3)
    assert gathered.recordings["t"].tolist() == [0.0, 0.01, 0.02]


def test_after_a_step_back_only_later_samples_count(tmp_path):
    times = [0.0, 0.1, 0.2, 0.1, 0.15, 0.2, 0.3]
    gathered = read_rows(tmp_path, *(f"{time},0,1,0.3" for time in times))
    refused = gathered.manifest.sources["csv"].rows_refused
    assert gathered.recordings["t"].tolist() == [0.0, 0.1, 0.2, 0.3]
    assert refused["time backwards"].rows == {"session.csv": [5, 6]}
    assert refused["time repeated"].rows == {"session.csv": [7]}


def test_one_sample_is_no_recording(tmp_path):
    write_csv(tmp_path, "broken_off.csv", rows=[HEADER, GOOD[0]])
    with pytest.raises(InputError, match="csv: no recording has more than one sample"):
        read(tmp_path, "csv")
    record = read_rows(tmp_path, *GOOD).manifest.sources["csv"]
    assert record.recordings == 1
    assert record.rows_refused["the only sample of its recording"].rows == {"broken_off.csv": [2]}


@pytest.mark.parametrize(
    ("rows", "problem"),
    [
        ([], "is empty"),
        ([HEADER], "holds no rows"),
        (["time,x,y,z", *GOOD], "row 1: the first line must be t,x,y,z"),
        ([HEADER, *(row.replace(",", ";") for row in GOOD)], "wrong number of fields"),
        ([HEADER, "0,1000,1,300", "0.1,1000,1,300"], "nothing in it can be used: farther"),
    ],
)
def test_a_file_without_a_usable_row_is_one_error(tmp_path, rows, problem):
    path = write_csv(tmp_path, rows=rows)
    path.write_text("\n".join(rows))
    with pytest.raises(InputError, match=rf"session\.csv.*{problem}"):
        read(tmp_path, "csv")


@pytest.mark.parametrize("source", WRITERS)
def test_a_folder_that_is_missing_or_empty_is_one_error(tmp_path, source):
    with pytest.raises(InputError, match=rf"{source}: there is no such folder; set ingest\.folder"):
        read(tmp_path, source)
    (tmp_path / source).mkdir()
    with pytest.raises(InputError, match=source):
        read(tmp_path, source)


def test_a_folder_that_is_not_set_or_cannot_be_looked_at_is_one_error(tmp_path, monkeypatch):
    monkeypatch.delenv("RALLYGAP_DATA", raising=False)
    with pytest.raises(InputError, match=r"ingest\.folder: is not set, nor is RALLYGAP_DATA"):
        read(None, "tt3d")
    with pytest.raises(InputError, match="cannot be read: File name too long"):
        read(tmp_path / ("x" * 300), "csv")


@pytest.mark.parametrize("relative", [False, True])
def test_the_environment_gives_the_folder_if_the_setting_does_not(tmp_path, monkeypatch, relative):
    WRITERS["tt3d"](tmp_path / "balls")
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))  # a temporary copy may be the working directory
    monkeypatch.setenv("RALLYGAP_DATA", "balls" if relative else str(tmp_path / "balls"))
    assert read(None, "tt3d").manifest.sources["tt3d"].recordings == 1


def test_hidden_files_and_folders_are_no_recordings(tmp_path):
    write_csv(tmp_path, "._session.csv", rows=["\x00\x05"])
    (tmp_path / "csv" / "old.csv").mkdir()
    assert read_rows(tmp_path, *GOOD).manifest.sources["csv"].recordings == 1


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One of all sources, with rows to be refused."""
    folder = tmp_path_factory.mktemp("sources")
    for write in WRITERS.values():
        write(folder)
    write_csv(folder, "bad.csv", rows=[HEADER, *GOOD, "0.02,0,1,0.3", "x,0,1,0.3"])
    write_csv(folder, "single.csv", rows=[HEADER, GOOD[0]])
    return folder


@pytest.fixture(scope="module")
def everything(folder):
    return read(folder, *WRITERS)


def test_the_manifest_has_checksums(folder, everything):
    (entry,) = everything.manifest.sources["tt3d"].files
    content = (folder / "tt3d" / "003.csv").read_bytes()
    assert (entry.file, entry.sha256) == ("003.csv", hashlib.sha256(content).hexdigest())


@pytest.mark.parametrize("batch_rows", [1, 5])
def test_the_size_of_a_batch_changes_nothing(folder, everything, monkeypatch, batch_rows):
    monkeypatch.setattr(source_import, "BATCH_ROWS", batch_rows)
    in_parts = read(folder, *WRITERS)
    assert in_parts.recordings.equals(everything.recordings)
    assert in_parts.launches.equals(everything.launches)
    assert in_parts.manifest == everything.manifest


def test_a_row_group_has_whole_recordings(tmp_path, monkeypatch):
    for name in "abcde":
        write_csv(tmp_path, f"{name}.csv", rows=[HEADER, *GOOD])
    monkeypatch.setattr(source_import, "BATCH_ROWS", 5)
    gather(IngestSettings(folder=tmp_path, sources=["csv"], arena=ARENA), 0, tmp_path)
    groups = read_row_groups(tmp_path / "recordings.parquet")
    names = [group["recording_id"].unique().tolist() for group in groups]
    assert names == [["csv/a", "csv/b"], ["csv/c", "csv/d"], ["csv/e"]]


def test_the_rate_is_the_median_over_all_recordings(tmp_path):
    for name, step in {"a": 0.005, "b": 0.005, "c": 0.02}.items():
        times = step * np.arange(20)
        rows = lines(",", times, np.tile([0.0, 1.0, 0.3], (20, 1)))
        write_csv(tmp_path, f"{name}.csv", [HEADER, *rows])
    assert read(tmp_path, "csv").manifest.sources["csv"].rate_hz == 200.0
