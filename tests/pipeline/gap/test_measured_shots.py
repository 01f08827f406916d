"""Shots from a folder of recordings: which they are, and what is known of them."""

from dataclasses import replace

import pandas as pd
import pytest

from rallygap.models.exam.simulate.trial import CAMERAS
from rallygap.pipeline.gap.measured_shots import LabelCounts, read_shots
from rallygap.pipeline.gap.wording import episodes_text, labels_text
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.recorded import write_recordings


def test_every_recorded_shot_is_found_with_its_labels(tmp_path):
    found = read_shots(write_recordings(tmp_path / "lab", shots=12), "csv")
    assert (found.name, found.recordings, len(found.shots)) == ("lab", 12, 12)
    assert found.shots.groups[0] == "lab/000"
    assert found.shots.labelled.sum(axis=1).min() > 10
    assert found.bounces > 0


def test_labels_may_be_left_out(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=6, spin_labels="none")
    assert not read_shots(folder, "csv").shots.labelled.any()


@pytest.mark.parametrize("noise", [0.003, 0.01])
def test_noisy_recordings_are_cut_by_their_noise(tmp_path, noise):
    cameras = replace(CAMERAS, position_noise=noise)
    found = read_shots(write_recordings(tmp_path / "lab", shots=12, cameras=cameras), "csv")
    assert found.noise == pytest.approx(noise, rel=0.15)
    assert len(found.shots) == 12


def test_refused_rows_are_counted(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=6)
    with (folder / "000.csv").open("a") as file:
        file.write("0.0,0,1,0.3,,,\n")
    assert read_shots(folder, "csv").refused == {"time backwards": 1}


def test_episodes_and_labels_that_are_left_out_have_a_reason(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=12)
    short, spun = folder / "000.csv", folder / "001.csv"
    pd.read_csv(short).head(10).to_csv(short, index=False)
    rows = pd.read_csv(spun)
    rows.loc[:4, ["wx", "wy", "wz"]] = 4000.0
    rows.to_csv(spun, index=False)
    found = read_shots(folder, "csv")
    assert episodes_text(found) == "11 of 12 episodes in 12 recordings; left out: 1 too short"
    assert (found.labels.implausible, found.labels.elsewhere) == (5, 10)
    assert found.labels.used == found.shots.labelled.sum()
    read = sum(len(pd.read_csv(path).dropna()) for path in folder.glob("*.csv"))
    assert found.labels.read == read


def test_labels_are_counted_with_reasons():
    counts = LabelCounts(read=1240, implausible=37, used=1203)
    assert labels_text(counts) == "1,203 of 1,240; left out: 37 implausible"
    outside = LabelCounts(read=10, implausible=0, used=8)
    assert labels_text(outside) == "8 of 10; left out: 2 outside these episodes"
    assert labels_text(LabelCounts(read=0, implausible=0, used=0)) == "none"


@pytest.mark.parametrize("source", ["nowhere", "arena"])
def test_only_sources_of_measured_balls_are_read(tmp_path, source):
    with pytest.raises(InputError, match=r"no source .* known: .*csv"):
        read_shots(tmp_path, source)


def test_launches_without_a_path_are_refused(tmp_path):
    (tmp_path / "rallies.json").write_text("[]")
    (tmp_path / "serves.json").write_text("[]")
    with pytest.raises(InputError, match="launches without a path"):
        read_shots(tmp_path, "competitive_robot_table_tennis")


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(InputError, match=r"lab: is not a folder.* files of csv"):
        read_shots(tmp_path / "lab", "csv")
