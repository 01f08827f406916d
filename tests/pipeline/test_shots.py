"""Shots from a folder of recordings: which they are, and what is known of them."""

from dataclasses import replace

import numpy as np
import pytest

from models.exam.trial import CAMERAS
from models.predictors.windows import Episode
from pipeline.episodes import MeasuredEpisode
from pipeline.errors import InputError
from pipeline.shots import is_shot, read_shots, read_training_shots, shots_of
from tests.pipeline.measured_shots import shot_tables, write_inputs
from tests.pipeline.recorded import write_recordings


def episode(samples=20, touched=None, bounces=(), unbroken=True):
    """An episode at 100 Hz whose ball touches something after ``touched`` samples."""
    times, places = 0.01 * np.arange(samples), np.zeros((samples, 3))
    arc = np.arange(samples) >= (samples if touched is None else touched)
    whole = Episode(times, places, places, places, arc < 0, arc.astype(int), np.array(bounces))
    return MeasuredEpisode("hall/0/00", "hall/0", "hall", "test", unbroken, whole)


def test_every_recorded_shot_is_found_with_its_labels(tmp_path):
    found = read_shots(write_recordings(tmp_path / "hall", shots=12), "csv")
    assert (found.name, found.recordings, len(found.shots)) == ("hall", 12, 12)
    assert found.shots.groups[0] == "hall/000"
    assert found.shots.labelled.sum(axis=1).min() > 10
    assert found.bounces > 0


def test_labels_may_be_left_out(tmp_path):
    folder = write_recordings(tmp_path / "hall", shots=6, spin_labels="none")
    assert not read_shots(folder, "csv").shots.labelled.any()


@pytest.mark.parametrize("noise", [0.003, 0.01])
def test_noisy_recordings_are_cut_by_their_noise(tmp_path, noise):
    cameras = replace(CAMERAS, position_noise=noise)
    found = read_shots(write_recordings(tmp_path / "hall", shots=12, cameras=cameras), "csv")
    assert found.noise == pytest.approx(noise, rel=0.15)
    assert len(found.shots) == 12


def test_refused_rows_are_counted(tmp_path):
    folder = write_recordings(tmp_path / "hall", shots=6)
    with (folder / "000.csv").open("a") as file:
        file.write("0.0,0,1,0.3,,,\n")
    assert read_shots(folder, "csv").refused == {"time backwards": 1}


@pytest.mark.parametrize(
    ("one", "expected"),
    [
        (episode(), True),
        (episode(touched=10, bounces=[0.095]), True),
        (episode(bounces=[0.2]), True),  # a bounce that ends the rally
        (episode(touched=10), False),  # at the net, say
        (episode(touched=10, bounces=[0.2]), False),
        (episode(samples=12), False),
        (episode(unbroken=False), False),
    ],
)
def test_a_shot_is_whole_long_enough_and_touches_the_table_alone(one, expected):
    assert is_shot(one) == expected


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
    with pytest.raises(InputError, match=r"hall: is not a folder.* files of csv"):
        read_shots(tmp_path / "hall", "csv")


def test_training_shots_are_those_that_predictors_learn_from(tmp_path):
    kept = [shot_tables("labelled", 3, split="train"), shot_tables("plain", 4, split="train")]
    others = [
        shot_tables("labelled", 4, split="validation"),
        shot_tables("labelled", 5, split="replay"),
        shot_tables("labelled", 6, split="train", unbroken=False),
    ]
    write_inputs(tmp_path, shots=[*kept, *others], sources=("labelled", "plain"))
    found = read_training_shots(tmp_path / "artifacts")
    names = {source: [one.episode_id for one in members] for source, members in found.items()}
    assert names == {"labelled": ["labelled/3/00"], "plain": ["plain/4/00"]}
    labelled, plain = (shots_of(members) for members in found.values())
    assert labelled.labelled.sum() == 1 and not plain.labelled.any()
