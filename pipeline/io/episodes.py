"""The segmented tables as episodes, the way predictors' windows take them."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.ball.types import Floats
from rallygap.models.predictors.windows import Episode
from rallygap.pipeline.io.artifacts import read_row_groups
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    POSITION_COLUMNS,
    SAMPLES,
    SPIN_COLUMNS,
    SPLITS,
    VELOCITY_COLUMNS,
    check_columns,
    checked,
    read_checked,
)
from rallygap.pipeline.runtime.errors import InputError

ORIGIN = ["episode_id", "recording_id", "source", "split", "unbroken"]
NO_TIMES = np.empty(0)
BY_SAMPLE = ("times", "positions", "velocities", "spins", "outlier", "arc")  # of an Episode


@dataclass(frozen=True)
class MeasuredEpisode:
    """An episode with where it comes from and what it is for.

    Attributes:
        episode_id: name.
        recording_id: the recording that it is from.
        source: of the recording.
        split: train, validation, test or replay.
        unbroken: whether its samples fit the paths between its contacts.
        episode: its samples.
        touched: (C,) s, when the ball touches something else than the table after the first sample.
        nets: (D,) s, those of these contacts that are with the net.
    """

    episode_id: str
    recording_id: str
    source: str
    split: str
    unbroken: bool
    episode: Episode
    touched: Floats
    nets: Floats

    def between(self, start: float, end: float) -> "MeasuredEpisode":
        """Return the episode with the samples at ``start`` <= t < ``end``, s; its contacts stay."""
        times = self.episode.times
        return replace(self, episode=_rows(self.episode, (times >= start) & (times < end)))


def read_episodes(
    folder: Path, labelled_once: set[str], splits: Collection[str] = SPLITS
) -> list[MeasuredEpisode]:
    """Read the episodes of a folder that the segment stage wrote, without the tosses of serves.

    Args:
        folder: with samples.parquet, contacts.parquet and episodes.parquet.
        labelled_once: sources with one spin label a shot. Such a label holds until the ball first
            touches something or is lost in a gap; after it the spin counts as not labelled.
        splits: which to read.

    Raises:
        InputError: a table is missing or broken, or the samples lack an episode.
    """
    contacts = read_checked(folder / "contacts.parquet", CONTACTS)
    episodes = read_checked(folder / "episodes.parquet", EPISODES)
    path = folder / "samples.parquet"
    check_columns(path, SAMPLES)
    return episodes_of(read_row_groups(path), contacts, episodes, labelled_once, splits, path)


def episodes_of(
    samples: Iterable[pd.DataFrame],
    contacts: pd.DataFrame,
    episodes: pd.DataFrame,
    labelled_once: set[str],
    splits: Collection[str] = SPLITS,
    path: Path | None = None,
) -> list[MeasuredEpisode]:
    """Return the episodes of segmented tables, without the tosses of serves.

    Args:
        samples: rows of ``SAMPLES`` in parts, each of whole episodes.
        contacts: rows of ``CONTACTS``.
        episodes: rows of ``EPISODES``.
        labelled_once: sources with one spin label a shot, as in ``read_episodes``.
        splits: which to return.
        path: of the samples, if they are from a file.

    Raises:
        InputError: samples are broken or lack an episode.
    """
    # The toss of a serve: no stroke begins it, and the serve ends it.
    unstruck = episodes["starts_with"].isin(["recording", "gap"])
    tossed = unstruck & (episodes["ends_with"] == "racket") & (episodes["bounces"] == 0)
    chosen = episodes[episodes["split"].isin(splits) & ~tossed]
    label_ends = _label_ends(contacts, episodes, labelled_once)
    kind = contacts["kind"]
    bounces, touched, nets = (
        {name: times.to_numpy() for name, times in contacts[of_kind].groupby("episode_id")["t"]}
        for of_kind in (kind == "table", kind != "table", kind == "net")
    )
    parts = dict(_episodes(samples, chosen, label_ends, path))
    measured = []
    for name, recording_id, source, split, unbroken in chosen[ORIGIN].itertuples(index=False):
        if name not in parts:
            problem = f"has no samples of episode {name}; run `dvc repro -f segment`"
            raise InputError(path or "samples", problem)
        episode = replace(parts[name], bounces=bounces.get(name, NO_TIMES))
        start, end = episode.times[[0, -1]]
        inside = (times.get(name, NO_TIMES) for times in (touched, nets))
        touches, met = (times[(times > start) & (times < end)] for times in inside)
        measured.append(
            MeasuredEpisode(name, recording_id, source, split, unbroken, episode, touches, met)
        )
    return measured


def _label_ends(
    contacts: pd.DataFrame, episodes: pd.DataFrame, labelled_once: set[str]
) -> dict[str, float]:
    """Return when the one label of a recording ends: whatever a ball touches changes its spin."""
    once = episodes[episodes["source"].isin(labelled_once)]
    after_gap = once[once["starts_with"] == "gap"].rename(columns={"start": "t"})
    touched = contacts[contacts["recording_id"].isin(once["recording_id"])]
    ends = pd.concat([table[["recording_id", "t"]] for table in (touched, after_gap)])
    return dict(ends.groupby("recording_id")["t"].min())


def _episodes(
    samples: Iterable[pd.DataFrame],
    chosen: pd.DataFrame,
    label_ends: dict[str, float],
    path: Path | None,
) -> Iterator[tuple[str, Episode]]:
    """Yield the chosen episodes by id, one part of the samples in memory at a time."""
    recordings = dict(zip(chosen["episode_id"], chosen["recording_id"], strict=True))
    for part in samples:
        wanted = checked(part[part["episode_id"].isin(chosen["episode_id"])], SAMPLES, path)
        whole = as_episode(wanted)
        for name, rows in wanted.groupby("episode_id", sort=False).indices.items():
            episode_id = str(name)
            own = _rows(whole, np.asarray(rows))
            labelled = own.times < label_ends.get(recordings[episode_id], np.inf)
            yield episode_id, replace(own, spins=np.where(labelled[:, None], own.spins, np.nan))


def as_episode(samples: pd.DataFrame) -> Episode:
    """Return a table of samples as one episode without bounces."""
    return Episode(
        times=samples["t"].to_numpy(),
        positions=samples[POSITION_COLUMNS].to_numpy(),
        velocities=samples[VELOCITY_COLUMNS].to_numpy(),
        spins=samples[SPIN_COLUMNS].to_numpy(),
        outlier=samples["outlier"].to_numpy(),
        arc=samples["arc"].to_numpy(),
        bounces=NO_TIMES,
    )


def _rows(episode: Episode, rows: NDArray[np.bool_] | NDArray[np.intp]) -> Episode:
    """Return an episode with some of its samples."""
    return replace(episode, **{name: getattr(episode, name)[rows] for name in BY_SAMPLE})
