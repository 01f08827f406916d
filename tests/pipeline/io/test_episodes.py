"""Episodes as predictors see them: how long the one spin label of a shot holds."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import table_writer, write_table
from rallygap.pipeline.io.episodes import read_episodes
from rallygap.pipeline.io.schemas import SAMPLES, empty
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.measured_shots import shot_tables

HALF = 50  # samples in the first of two episodes


def write(folder, samples, contacts, episodes):
    write_table(folder / "samples.parquet", samples)
    write_table(folder / "contacts.parquet", contacts)
    write_table(folder / "episodes.parquet", episodes)


def cut_in_two(folder, *, starts_with, kind):
    """Leave one labelled shot as two episodes, the second begun by a racket or a gap."""
    samples, contacts, episodes, _ = shot_tables("labelled", 0)
    samples.loc[HALF:, "episode_id"] = "labelled/0/01"
    start = samples["t"][HALF]
    second = {"episode_id": "labelled/0/01", "starts_with": starts_with, "start": start}
    contacts = contacts.assign(episode_id="labelled/0/01", kind=kind or "none", t=start)
    contacts = contacts if kind else contacts.iloc[:0]
    write(folder, samples, contacts, pd.concat([episodes, episodes.assign(**second)]))


@pytest.mark.parametrize(("starts_with", "kind"), [("racket", "racket"), ("gap", None)])
def test_the_label_of_a_shot_does_not_outlive_a_stroke_or_a_gap(tmp_path, starts_with, kind):
    cut_in_two(tmp_path, starts_with=starts_with, kind=kind)
    first, second = read_episodes(tmp_path, {"labelled"})
    assert np.isfinite(first.episode.spins).all()
    assert np.isnan(second.episode.spins).all()
    labelled_by_sample = read_episodes(tmp_path, set())
    assert all(np.isfinite(one.episode.spins).all() for one in labelled_by_sample)


@pytest.mark.parametrize("wanted", [["train"], ["test"], ["train", "test"]])
def test_only_the_splits_asked_for_are_read(tmp_path, wanted):
    parts = [shot_tables("labelled", number) for number in range(2)]
    samples, contacts, episodes, _ = zip(*parts, strict=True)
    table = pd.concat(episodes).assign(split=["train", "test"])
    write(tmp_path, pd.concat(samples), pd.concat(contacts), table)
    with table_writer(tmp_path / "samples.parquet", empty(SAMPLES)) as add:
        for rows in samples:
            add(rows)
    read = read_episodes(tmp_path, set(), wanted)
    assert [one.split for one in read] == wanted
    for one in read:
        own = samples[["train", "test"].index(one.split)]
        np.testing.assert_array_equal(one.episode.positions, own[["px", "py", "pz"]])
        assert len(one.episode.bounces) == 1


def test_contacts_with_other_things_than_the_table_are_read_with_the_net_apart(tmp_path):
    samples, contacts, episodes, _ = shot_tables("labelled", 0)
    moments = [samples["t"][0], 0.1, 0.2, samples["t"].iloc[-1] + 0.01]  # two inside the episode
    kinds = ["racket", "net", "unknown", "floor"]
    others = [contacts.assign(t=t, kind=kind) for t, kind in zip(moments, kinds, strict=True)]
    write(tmp_path, samples, pd.concat([contacts, *others]), episodes)
    (found,) = read_episodes(tmp_path, set())
    assert (found.touched.tolist(), found.nets.tolist()) == ([0.1, 0.2], [0.1])
    part = found.between(0.1, 0.2)
    assert (part.episode.times.min(), part.episode.times.max() < 0.2) == (0.1, True)
    assert len(part.episode.positions) == len(part.episode.times) < len(samples)


def test_an_episode_without_samples_is_named(tmp_path):
    samples, contacts, episodes, _ = shot_tables("labelled", 0)
    more = episodes.assign(episode_id="labelled/0/09")
    write(tmp_path, samples, contacts, pd.concat([episodes, more]))
    with pytest.raises(InputError, match=r"samples\.parquet: has no .* episode labelled/0/09"):
        read_episodes(tmp_path, set())
