"""Episodes as predictors see them: how long the one spin label of a shot holds."""

import numpy as np
import pandas as pd
import pytest

from pipeline.artifacts import write_table
from pipeline.episodes import read_episodes
from tests.stages.test_evaluate_predictor import episode_tables

HALF = 50  # samples in the first of two episodes


def cut_in_two(folder, *, starts_with, kind):
    """Leave one labelled shot as two episodes, the second begun by a racket or a gap."""
    samples, contact, episode = episode_tables("lab", 0, labelled=True)
    samples.loc[HALF:, "episode_id"] = "lab/0/01"
    start = samples["t"][HALF]
    second = {"episode_id": "lab/0/01", "starts_with": starts_with, "start": start}
    contacts = [contact | {"episode_id": "lab/0/01", "kind": kind, "t": start}] if kind else []
    write_table(folder / "samples.parquet", samples)
    write_table(
        folder / "contacts.parquet",
        pd.DataFrame(contacts, columns=list(contact)).astype(
            {name: type(value) for name, value in contact.items()}
        ),
    )
    write_table(folder / "episodes.parquet", pd.DataFrame([episode, episode | second]))


@pytest.mark.parametrize(("starts_with", "kind"), [("racket", "racket"), ("gap", None)])
def test_the_label_of_a_shot_does_not_outlive_a_stroke_or_a_gap(tmp_path, starts_with, kind):
    cut_in_two(tmp_path, starts_with=starts_with, kind=kind)
    first, second = read_episodes(tmp_path, {"lab"})
    assert np.isfinite(first.episode.spins).all()
    assert np.isnan(second.episode.spins).all()


def test_labels_of_every_sample_hold_whatever_the_ball_meets(tmp_path):
    cut_in_two(tmp_path, starts_with="racket", kind="racket")
    assert all(np.isfinite(one.episode.spins).all() for one in read_episodes(tmp_path, set()))
