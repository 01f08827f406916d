"""The stage segment, from ingested recordings to artefacts and report."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import (
    read_json,
    read_row_groups,
    read_table,
    table_writer,
    write_table,
)
from rallygap.pipeline.io.schemas import CONTACTS, EPISODES, RECORDINGS, SAMPLES, checked, empty
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import ARENA
from tests.stages.outputs import table, written
from tests.stages.small_runs import run_ingest, run_segment

TABLES = {"samples": SAMPLES, "contacts": CONTACTS, "episodes": EPISODES}


@pytest.fixture(scope="module")
def run(ingested, tmp_path_factory):
    """One run on what `ingest` left; not to be changed."""
    return run_segment(copied(ingested, tmp_path_factory.mktemp("run")))


def copied(root, folder):
    return Path(shutil.copytree(root, folder, dirs_exist_ok=True))


def test_tables_keep_their_contracts(run):
    tables = {
        name: checked(read_table(run.artifact(f"{name}.parquet")), contract)
        for name, contract in TABLES.items()
    }
    assert set(tables["episodes"]["starts_with"]) == {"launch"}
    assert len(tables["episodes"]) == ARENA.cannon_shots
    splits = table(run, "splits")
    assert splits["episodes"].sum() == ARENA.cannon_shots
    assert set(splits["group"]) == {"cannon"}
    metrics = read_json(run.report("metrics.json"))["arena"]
    residual = read_table(run.artifact("episodes.parquet"))["residual"].median()
    assert metrics["episodes"] == ARENA.cannon_shots
    assert metrics["median_residual_mm"] == pytest.approx(1e3 * residual, abs=1e-3)


def test_row_groups_make_no_difference(ingested, run, tmp_path):
    path = ingested / "artifacts/ingest/recordings.parquet"
    recordings = read_table(path)
    parts = tmp_path / "artifacts/ingest"
    with table_writer(parts / "recordings.parquet", empty(RECORDINGS)) as add:
        for _, rows in recordings.groupby("recording_id"):
            add(rows)
    (parts / "manifest.json").write_bytes(path.with_name("manifest.json").read_bytes())
    again = run_segment(tmp_path)
    assert len(list(read_row_groups(again.artifact("samples.parquet")))) == ARENA.cannon_shots
    for name in TABLES:
        one, other = (read_table(each.artifact(f"{name}.parquet")) for each in (run, again))
        pd.testing.assert_frame_equal(one, other)


def test_a_second_run_writes_the_same_bytes_and_warns_of_shortages(run, tmp_path, capsys):
    again = run_segment(copied(run.root, tmp_path))
    assert written(again) == written(run)
    assert "warning: arena has 1 of 500 shots to test on" in capsys.readouterr().err


def test_no_recording_is_an_input_error(ingested, tmp_path):
    path = copied(ingested, tmp_path) / "artifacts/ingest/recordings.parquet"
    write_table(path, read_table(path).iloc[:0])
    with pytest.raises(InputError, match="holds no recording"):
        run_segment(tmp_path)


@pytest.mark.real
def test_real_rallies(tmp_path, real_data):
    run_ingest(tmp_path, real_data, ["tt3d"])
    run = run_segment(tmp_path)
    episodes = read_table(run.artifact("episodes.parquet"))
    assert len(episodes) == 70
    assert len(read_table(run.artifact("contacts.parquet"))) == 71
    assert episodes["unbroken"].mean() > 0.9
