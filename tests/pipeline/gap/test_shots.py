"""Shots: which episodes they are, and which of them serve for training."""

import numpy as np
import pytest

from models.predictors.windows import Episode
from pipeline.gap.shots import is_shot, read_training_shots, shots_of
from pipeline.io.episodes import MeasuredEpisode
from tests.pipeline.measured_shots import shot_tables, write_inputs


def episode(samples=20, touched=None, bounces=(), unbroken=True):
    """An episode at 100 Hz whose ball touches something after ``touched`` samples."""
    times, places = 0.01 * np.arange(samples), np.zeros((samples, 3))
    arc = np.arange(samples) >= (samples if touched is None else touched)
    whole = Episode(times, places, places, places, arc < 0, arc.astype(int), np.array(bounces))
    return MeasuredEpisode("lab/0/00", "lab/0", "lab", "test", unbroken, whole)


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
