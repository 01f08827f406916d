"""The score of segmentation on simulated recordings, from artefacts to report."""

import shutil
from types import SimpleNamespace

import pandas as pd
import pytest

from rallygap.models.segmentation.settings import ScoringSettings
from rallygap.pipeline.io.artifacts import read_json, read_table, write_table
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.score_segmentation import score_segmentation
from tests.pipeline.sources.made_up import ARENA
from tests.stages.outputs import table
from tests.stages.small_runs import run_ingest, run_segment


def run_score(root):
    params = SimpleNamespace(score_segmentation=ScoringSettings(), seed=0)
    run = StageRun("score_segmentation", root, params)
    score_segmentation(run)
    return run


@pytest.fixture
def root(ingested, tmp_path):
    """Where the previous stages left their artefacts."""
    shutil.copytree(ingested, tmp_path, dirs_exist_ok=True)
    run_segment(tmp_path)
    return tmp_path


def assign_to_split(root, split="test"):
    path = root / "artifacts/segment/episodes.parquet"
    episodes = read_table(path)
    write_table(path, episodes.assign(split=pd.Series(split, index=episodes.index, dtype="str")))


def overall(run):
    """Scores of contacts of all levels, by kind."""
    return run.kept("score_segmentation", "contacts").query("level == 'all'").set_index("kind")


def test_bounces_of_test_recordings_are_scored_and_a_missed_one_lowers_recall(root):
    assign_to_split(root)
    run = run_score(root)
    assert table(run, "contacts")["level"].tolist() == ["cannon", "all"]
    found = overall(run).loc["table"]
    true = read_table(root / "artifacts/ingest/true_contacts.parquet")
    assert found["precision"] == found["recall"] == 1.0
    assert found["time error rms (ms)"] < 2.0
    assert found["contacts"] <= (true["kind"] == "table").sum()
    path = root / "artifacts/segment/contacts.parquet"
    contacts = read_table(path)
    write_table(path, contacts.drop(contacts.index[contacts["kind"] == "table"][0]))
    run = run_score(root)
    found = overall(run).loc["table"]
    assert found["precision"] == 1.0
    assert found["recall"] == pytest.approx(1 - 1 / found["contacts"])
    metrics = read_json(run.report("metrics.json"))
    assert metrics["table"]["recall"] == pytest.approx(found["recall"], abs=1e-4)


def test_only_test_recordings_are_scored(root, capsys):
    assign_to_split(root, "train")
    run = run_score(root)
    assert read_json(run.report("metrics.json")) == {}
    assert "no contacts to score" in capsys.readouterr().err
    assert table(run, "contacts").empty


@pytest.mark.slow
def test_contacts_of_games_are_found(tmp_path):
    run_ingest(tmp_path, arena=ARENA.model_copy(update={"game_episodes": 1500}), seed=11)
    run_segment(tmp_path)
    assign_to_split(tmp_path)
    found = overall(run_score(tmp_path)).loc[["racket", "table"]]
    assert (found["contacts"] > 1500).all()
    assert (found[["precision", "recall"]] >= 0.99).all(axis=None)
