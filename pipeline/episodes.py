"""The segmented tables as episodes, the way predictors' windows take them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from models.predictors.windows import Episode
from pipeline.artifacts import read_table
from pipeline.contracts import (
    CONTACTS,
    EPISODES,
    POSITION_COLUMNS,
    SAMPLES,
    SPIN_COLUMNS,
    VELOCITY_COLUMNS,
    checked,
)


@dataclass(frozen=True)
class MeasuredEpisode:
    """An episode with where it comes from."""

    episode_id: str
    recording_id: str
    source: str
    unbroken: bool
    episode: Episode


def read_episodes(folder: Path, labelled_once: set[str]) -> list[MeasuredEpisode]:
    """Read every episode of a folder that the segment stage wrote.

    Args:
        folder: with samples.parquet, contacts.parquet and episodes.parquet.
        labelled_once: sources with one spin label a shot. Such a label holds until the ball first
            touches something or is lost in a gap; after it the spin counts as not labelled.
    """
    samples = checked(read_table(folder / "samples.parquet"), SAMPLES)
    contacts = checked(read_table(folder / "contacts.parquet"), CONTACTS)
    episodes = checked(read_table(folder / "episodes.parquet"), EPISODES)
    return list(_assembled(samples, contacts, episodes, labelled_once))


def _assembled(
    samples: pd.DataFrame, contacts: pd.DataFrame, episodes: pd.DataFrame, labelled_once: set[str]
) -> Iterator[MeasuredEpisode]:
    bounces = contacts[contacts["kind"] == "table"].groupby("episode_id")["t"]
    bounce_times = {name: times.to_numpy() for name, times in bounces}
    label_ends = _label_ends(contacts, episodes)
    members = dict(tuple(samples.groupby("episode_id", sort=False)))
    for row in episodes.to_dict("records"):
        name, recording_id, source = row["episode_id"], row["recording_id"], row["source"]
        times = bounce_times.get(name, np.empty(0))
        label_end = label_ends.get(recording_id, np.inf) if source in labelled_once else np.inf
        episode = _episode(members[name], times, label_end)
        yield MeasuredEpisode(name, recording_id, source, row["unbroken"], episode)


def _label_ends(contacts: pd.DataFrame, episodes: pd.DataFrame) -> "pd.Series[float]":
    """Return when the one label of a recording ends: whatever a ball touches changes its spin."""
    after_gap = episodes[episodes["starts_with"] == "gap"].rename(columns={"start": "t"})
    ends = pd.concat([table[["recording_id", "t"]] for table in (contacts, after_gap)])
    return ends.groupby("recording_id")["t"].min()


def _episode(samples: pd.DataFrame, bounces: np.ndarray, label_end: float) -> Episode:
    times = samples["t"].to_numpy()
    spins = samples[SPIN_COLUMNS].to_numpy(copy=True)
    spins[times >= label_end] = np.nan
    return Episode(
        times=times,
        positions=samples[POSITION_COLUMNS].to_numpy(),
        velocities=samples[VELOCITY_COLUMNS].to_numpy(),
        spins=spins,
        outlier=samples["outlier"].to_numpy(),
        arc=samples["arc"].to_numpy(),
        bounces=bounces,
    )
