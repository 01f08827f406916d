"""The segment stage, from what ingest left to artefacts and report."""

from types import SimpleNamespace

import pytest

from models.segmentation.settings import SegmentSettings
from pipeline.artifacts import read_json, read_table, write_table
from pipeline.contracts import CONTACTS, EPISODES, SAMPLES, checked
from pipeline.errors import InputError
from pipeline.run import StageRun
from pipeline.sources.settings import IngestSettings
from stages.ingest import ingest
from stages.segment import segment
from tests.pipeline.sources.made_up import CANNON

TABLES = {"samples": SAMPLES, "contacts": CONTACTS, "episodes": EPISODES}


def run_ingest(root, folder=None, source="synthetic_cannon"):
    settings = IngestSettings(folder=folder, sources=[source], synthetic_cannon=CANNON)
    ingest(StageRun("ingest", root, SimpleNamespace(ingest=settings, seed=0)))


def run_segment(root):
    run = StageRun("segment", root, SimpleNamespace(segment=SegmentSettings(), seed=0))
    segment(run)
    return run


def contents(root):
    return {path.name: path.read_bytes() for path in root.rglob("segment/**/*") if path.is_file()}


def test_tables_are_left_for_the_next_stages(tmp_path):
    run_ingest(tmp_path)
    run = run_segment(tmp_path)
    tables = {
        name: checked(read_table(run.artifact(f"{name}.parquet")), contract)
        for name, contract in TABLES.items()
    }
    assert set(tables["episodes"]["starts_with"]) == {"launch"}
    assert len(tables["episodes"]) == CANNON.shots


def test_metrics_agree_with_the_tables(tmp_path):
    run_ingest(tmp_path)
    run = run_segment(tmp_path)
    metrics = read_json(run.report("metrics.json"))["synthetic_cannon"]
    contacts = read_table(run.artifact("contacts.parquet"))
    episodes = read_table(run.artifact("episodes.parquet"))
    assert metrics["recordings"] == metrics["episodes"] == CANNON.shots
    assert metrics["contacts"] == contacts["kind"].value_counts().to_dict()
    assert metrics["unbroken_share"] == pytest.approx(episodes["unbroken"].mean(), abs=1e-4)
    assert metrics["gaps"] == 0


def test_each_source_has_its_figure(tmp_path):
    run_ingest(tmp_path)
    run = run_segment(tmp_path)
    assert [item.file for item in run.items] == ["figures/cuts_synthetic_cannon.png"]
    assert run.report("figures/cuts_synthetic_cannon.png").stat().st_size > 10_000


def test_running_twice_writes_the_same_bytes(tmp_path):
    run_ingest(tmp_path)
    run_segment(tmp_path)
    first = contents(tmp_path)
    run_segment(tmp_path)
    assert contents(tmp_path) == first
    assert len(first) == 5


def test_no_recording_is_an_input_error(tmp_path):
    run_ingest(tmp_path)
    path = tmp_path / "artifacts/ingest/recordings.parquet"
    write_table(path, read_table(path).iloc[:0])
    with pytest.raises(InputError, match="holds no recording"):
        run_segment(tmp_path)


def test_missing_input_names_what_to_run(tmp_path):
    with pytest.raises(InputError, match="run the stage that writes it"):
        run_segment(tmp_path)


@pytest.mark.real
def test_real_rallies(tmp_path, real_data):
    run_ingest(tmp_path, real_data, "tt3d")
    metrics = read_json(run_segment(tmp_path).report("metrics.json"))["tt3d"]
    assert metrics["recordings"] == metrics["episodes"] == 70
    assert metrics["contacts"] == {"table": 70, "unknown": 1}
    assert metrics["unbroken_share"] > 0.9
