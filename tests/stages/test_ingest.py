"""The ingest stage, from files to artefacts and report."""

import re

import pytest

from rallygap.pipeline.io.artifacts import read_json, read_table
from rallygap.pipeline.io.schemas import LAUNCHES, POINTS, RECORDINGS, TRUE_CONTACTS, checked
from rallygap.pipeline.io.source_manifest import read_manifest
from tests.pipeline.sources.made_up import ARENA, WRITERS, write_tt3d
from tests.stages.outputs import table, written
from tests.stages.small_runs import run_ingest


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    """A folder with every source."""
    folder = tmp_path_factory.mktemp("data")
    for write in WRITERS.values():
        write(folder)
    return folder


@pytest.fixture(scope="module")
def whole(everything, tmp_path_factory):
    """A run on all sources; not to be changed."""
    return run_ingest(tmp_path_factory.mktemp("run"), everything, ["arena", *WRITERS])


def test_tables_and_manifest_are_left_for_the_next_stages_and_truth_apart(whole):
    recordings = checked(read_table(whole.artifact("recordings.parquet")), RECORDINGS)
    launches = checked(read_table(whole.artifact("launches.parquet")), LAUNCHES)
    manifest = read_manifest(whole.artifact("manifest.json"))
    assert len(recordings) + len(launches) == sum(s.rows_kept for s in manifest.sources.values())
    assert list(manifest.sources) == ["arena", *WRITERS]
    contacts = checked(read_table(whole.artifact("true_contacts.parquet")), TRUE_CONTACTS)
    checked(read_table(whole.artifact("points.parquet")), POINTS)
    simulated = recordings["recording_id"].str.startswith("arena/")
    assert set(contacts["recording_id"]) == set(recordings.loc[simulated, "recording_id"])
    assert read_json(whole.artifact("truth.json"))["seed"] == 0


def test_the_report_shows_every_source_and_all_launches(whole):
    sources = table(whole, "sources", "source")
    assert list(sources.index) == ["arena", *WRITERS]
    assert sources.loc["tt3d", "licence"] == "not stated upstream"
    launches = table(whole, "launch_distributions", "quantity").loc["speed (m/s)"]
    assert launches.set_index(["stroke", "group"])["launches"].to_dict() == {
        ("cannon", "cannon"): ARENA.cannon_shots,
        ("rally", "measured"): 2,
        ("serve", "measured"): 1,
    }


def test_measured_balls_leave_an_empty_truth_and_metrics_say_what_was_read_and_refused(tmp_path):
    write_tt3d(tmp_path)
    with (tmp_path / "tt3d" / "003.csv").open("a") as file:
        file.write("15.021,0,0,0.3\n15.030,0,0,zero\n")
    run = run_ingest(tmp_path / "run", tmp_path, ["tt3d"])
    assert read_json(run.artifact("truth.json")) is None
    assert read_table(run.artifact("true_contacts.parquet")).empty
    assert read_table(run.artifact("points.parquet")).empty
    assert len(table(run, "launch_distributions")) == 0
    assert read_json(run.report("metrics.json"))["tt3d"] == {"recordings": 1}
    row = table(run, "sources", "source").loc["tt3d"]
    assert row["rows"] == 4
    assert sum(int(count) for count in re.findall(r"\d+", row["refused"])) == 2


def test_running_twice_writes_the_same_bytes_which_do_not_tell_where_the_data_lay(
    tmp_path, everything, whole
):
    again = written(run_ingest(tmp_path, everything, ["arena", *WRITERS]))
    assert again == written(whole)
    assert len(again) == 8
    assert not [name for name, content in again.items() if str(everything).encode() in content]
