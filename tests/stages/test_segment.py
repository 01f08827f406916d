"""The stage segment and its score, from ingested recordings to artefacts and reports."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from rallygap.models.segmentation.settings import ScoringSettings
from rallygap.pipeline.io.artifacts import (
    read_json,
    read_row_groups,
    read_table,
    table_writer,
    write_table,
)
from rallygap.pipeline.io.schemas import CONTACTS, EPISODES, RECORDINGS, SAMPLES, checked, empty
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.score_segmentation import score_segmentation
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


def run_score(root):
    params = SimpleNamespace(score_segmentation=ScoringSettings(), seed=0)
    run = StageRun("score_segmentation", root, params)
    score_segmentation(run)
    return run


def assign_to_split(root, split="test"):
    path = root / "artifacts/segment/episodes.parquet"
    episodes = read_table(path)
    write_table(path, episodes.assign(split=pd.Series(split, index=episodes.index, dtype="str")))


def overall(run):
    """Scores of contacts of all levels, by kind."""
    return run.kept("score_segmentation", "contacts").query("level == 'all'").set_index("kind")


def test_bounces_of_test_recordings_are_scored_and_a_missed_one_lowers_recall(run, tmp_path):
    root = copied(run.root, tmp_path)
    assign_to_split(root)
    score = run_score(root)
    assert table(score, "contacts")["level"].tolist() == ["cannon", "all"]
    found = overall(score).loc["table"]
    true = read_table(root / "artifacts/ingest/true_contacts.parquet")
    assert found["precision"] == found["recall"] == 1.0
    assert found["time error rms (ms)"] < 2.0
    assert found["contacts"] <= (true["kind"] == "table").sum()
    path = root / "artifacts/segment/contacts.parquet"
    contacts = read_table(path)
    write_table(path, contacts.drop(contacts.index[contacts["kind"] == "table"][0]))
    score = run_score(root)
    found = overall(score).loc["table"]
    assert found["precision"] == 1.0
    assert found["recall"] == pytest.approx(1 - 1 / found["contacts"])
    metrics = read_json(score.report("metrics.json"))
    assert metrics["table"]["recall"] == pytest.approx(found["recall"], abs=1e-4)


def test_only_test_recordings_are_scored(run, tmp_path, capsys):
    assign_to_split(copied(run.root, tmp_path), "train")
    score = run_score(tmp_path)
    assert read_json(score.report("metrics.json")) == {}
    assert "no contacts to score" in capsys.readouterr().err
    assert table(score, "contacts").empty


@pytest.mark.slow
def test_contacts_of_games_are_found(tmp_path):
    run_ingest(tmp_path, arena=ARENA.model_copy(update={"game_episodes": 1500}), seed=11)
    run_segment(tmp_path)
    assign_to_split(tmp_path)
    found = overall(run_score(tmp_path)).loc[["racket", "table"]]
    assert (found["contacts"] > 1500).all()
    assert (found[["precision", "recall"]] >= 0.99).all(axis=None)
