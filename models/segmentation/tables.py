"""Segmentation of a table of recordings into tables of samples, contacts and episodes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.contacts import Contact
from rallygap.models.segmentation.cuts import Cuts, cut
from rallygap.models.segmentation.episodes import Episode, episodes
from rallygap.models.segmentation.settings import SegmentSettings

Row = dict[str, Any]

POSITION = ["px", "py", "pz"]
VELOCITY = ["vx", "vy", "vz"]
SPIN = ["wx", "wy", "wz"]
SAMPLE_COLUMNS = ["recording_id", "episode_id", "arc", "t"]
SAMPLE_COLUMNS += [*POSITION, *VELOCITY, *SPIN, "outlier"]
CONTACT_TYPES: dict[str, Any] = {
    "recording_id": "str",
    "episode_id": "str",
    "kind": "str",
    "t": float,
    **dict.fromkeys(POSITION, float),
    "speed_change": float,
}
EPISODE_TYPES: dict[str, Any] = {
    "episode_id": "str",
    "recording_id": "str",
    "source": "str",
    "start": float,
    "end": float,
    "starts_with": "str",
    "ends_with": "str",
    "samples": int,
    "outliers": int,
    "bounces": int,
    "residual": float,
    "unbroken": bool,
}

# Labels of a sample; an array, since recordings are many and short.
LABELS = np.dtype([
    ("episode", int), ("arc", int), ("velocity", float, 3), ("outlier", bool), ("residual", float),
])  # fmt: skip
NO_EPISODE = -1


@dataclass(frozen=True)
class Segmented:
    """Segmented recordings: one row per sample, contact and episode."""

    samples: pd.DataFrame
    contacts: pd.DataFrame
    episodes: pd.DataFrame


def segment_recordings(
    recordings: pd.DataFrame, starts_with_launch: Callable[[str], bool], settings: SegmentSettings
) -> Segmented:
    """Cut recordings into episodes.

    Args:
        recordings: one row per sample: recording_id, t, position, spin; at least one row.
        starts_with_launch: whether the recording with this id is one shot from its launch on.
        settings: noise, costs and limits.
    """
    labels = np.empty(len(recordings), LABELS)
    contact_rows: list[Row] = []
    episode_rows: list[Row] = []
    t, positions = recordings["t"].to_numpy(), recordings[POSITION].to_numpy()
    codes, ids = pd.factorize(recordings["recording_id"])
    order = np.argsort(codes, kind="stable")
    bounds = np.flatnonzero(np.diff(codes[order])) + 1
    for recording_id, rows in zip(map(str, ids), np.split(order, bounds), strict=True):
        cuts = cut(t[rows], positions[rows], settings)
        launched = starts_with_launch(recording_id)
        joined = list(episodes(cuts, "launch" if launched else "recording"))
        labels[rows] = _labels(cuts, joined, len(episode_rows))
        for number, episode in enumerate(joined):
            name = {"recording_id": recording_id, "episode_id": f"{recording_id}/{number:02d}"}
            contact_rows.extend(name | _contact(contact) for contact in episode.contacts)
            episode_rows.append(name | _episode(episode))
    contacts = pd.DataFrame(contact_rows, columns=list(CONTACT_TYPES)).astype(CONTACT_TYPES)
    table = _with_sample_columns(episode_rows, labels, t, settings)
    return Segmented(_samples(recordings, labels, table["episode_id"]), contacts, table)


def _labels(cuts: Cuts, joined: list[Episode], first: int) -> NDArray[np.void]:
    """Return the labels of a recording's samples; its episodes are numbered from ``first`` on."""
    # One more entry for the samples without a flight: their index -1 is the last entry.
    numbers = np.full(cuts.flights + 1, NO_EPISODE)
    arcs = np.zeros(cuts.flights + 1, dtype=np.int64)
    for number, episode in enumerate(joined, start=first):
        numbers[episode.flights] = number
        arcs[episode.flights] = range(len(episode.flights))
    labels = np.empty(len(cuts.flight), LABELS)
    labels["episode"], labels["arc"] = numbers[cuts.flight], arcs[cuts.flight]
    labels["velocity"], labels["outlier"] = cuts.velocity, cuts.outlier
    labels["residual"] = cuts.residual
    return labels


def _contact(contact: Contact) -> Row:
    values = (contact.kind, contact.time, *contact.position, contact.speed_change)
    return dict(zip(("kind", "t", *POSITION, "speed_change"), values, strict=True))


def _episode(episode: Episode) -> Row:
    return {
        "start": episode.contacts[0].time if episode.starts_with == "racket" else np.nan,
        "end": episode.end_contact.time if episode.end_contact else np.nan,
        "starts_with": episode.starts_with,
        "ends_with": episode.ends_with,
        "bounces": sum(contact.kind == "table" for contact in episode.contacts),
    }


def _with_sample_columns(
    rows: list[Row], labels: NDArray[np.void], t: Floats, settings: SegmentSettings
) -> pd.DataFrame:
    """Add what the samples give: times of ends without a contact, counts and residuals."""
    table = pd.DataFrame(rows, columns=list(EPISODE_TYPES))
    square = np.where(labels["outlier"], np.nan, labels["residual"]) ** 2
    samples = pd.DataFrame({"t": t, "outlier": labels["outlier"], "square": square})
    inside = labels["episode"] != NO_EPISODE
    grouped = samples[inside].groupby(labels["episode"][inside])
    table["source"] = table["recording_id"].str.split("/").str[0]
    table["start"] = table["start"].fillna(grouped["t"].first())
    table["end"] = table["end"].fillna(grouped["t"].last())
    table["samples"], table["outliers"] = grouped.size(), grouped["outlier"].sum()
    table["residual"] = np.sqrt(grouped["square"].mean())
    table["unbroken"] = table["residual"] < settings.unbroken_residual
    return table.astype(EPISODE_TYPES)


def _samples(
    recordings: pd.DataFrame, labels: NDArray[np.void], ids: "pd.Series[str]"
) -> pd.DataFrame:
    """Return the samples that are in an episode, with their labels."""
    inside = labels["episode"] != NO_EPISODE
    samples = recordings[inside].reset_index(drop=True)
    samples["episode_id"] = ids.take(labels["episode"][inside]).set_axis(samples.index)
    samples["arc"], samples["outlier"] = labels["arc"][inside], labels["outlier"][inside]
    samples[VELOCITY] = labels["velocity"][inside]
    return samples[SAMPLE_COLUMNS]
