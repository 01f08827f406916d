"""Recordings in; tables of samples, contacts and episodes out."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.segmentation.contacts import Contact
from models.segmentation.cuts import Cuts, cut
from models.segmentation.episodes import Episode, episodes
from models.segmentation.settings import SegmentSettings

Indices = NDArray[np.int64]

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


@dataclass(frozen=True)
class Segmented:
    """What recordings are cut into, one row a sample, a contact or an episode."""

    samples: pd.DataFrame
    contacts: pd.DataFrame
    episodes: pd.DataFrame


def segment_recordings(
    recordings: pd.DataFrame, cannons: Collection[str], settings: SegmentSettings
) -> Segmented:
    """Cut recordings into episodes.

    Args:
        recordings: one row a sample: recording_id, t, position, spin; at least one row.
        cannons: the sources whose recordings begin with a launch.
        settings: noise, costs and limits.
    """
    labels: list[pd.DataFrame] = []
    contact_rows: list[dict[str, Any]] = []
    episode_rows: list[dict[str, Any]] = []
    t, positions = recordings["t"].to_numpy(), recordings[POSITION].to_numpy()
    for recording_id, rows in _rows_by_recording(recordings):
        source = recording_id.split("/")[0]
        cuts = cut(t[rows], positions[rows], settings)
        found = list(episodes(cuts, "launch" if source in cannons else "recording"))
        ids = [f"{recording_id}/{number:02d}" for number in range(len(found))]
        labels.append(_labels(cuts, found, ids).set_index(rows))
        for episode_id, episode in zip(ids, found, strict=True):
            name = {"recording_id": recording_id, "episode_id": episode_id}
            contact_rows.extend(name | _contact(contact) for contact in episode.contacts)
            episode_rows.append(name | {"source": source} | _episode(episode))
    labelled = recordings.reset_index(drop=True).join(pd.concat(labels))
    labelled = labelled[labelled["episode_id"] != ""]
    return Segmented(
        labelled[SAMPLE_COLUMNS].reset_index(drop=True),
        pd.DataFrame(contact_rows, columns=list(CONTACT_TYPES)).astype(CONTACT_TYPES),
        _measured(episode_rows, labelled, settings),
    )


def _rows_by_recording(recordings: pd.DataFrame) -> Iterator[tuple[str, Indices]]:
    codes, ids = pd.factorize(recordings["recording_id"])
    order = np.argsort(codes, kind="stable")
    bounds = np.flatnonzero(np.diff(codes[order])) + 1
    return zip(map(str, ids), np.split(order, bounds), strict=True)


def _labels(cuts: Cuts, found: list[Episode], ids: list[str]) -> pd.DataFrame:
    """Return what segmentation says of each sample; episode_id is empty outside episodes."""
    # One more entry, for the samples without a flight: their number -1 is the last index.
    names = np.full(cuts.flights + 1, "", dtype=object)
    arcs = np.zeros(cuts.flights + 1, dtype=int)
    for episode_id, episode in zip(ids, found, strict=True):
        names[episode.flights] = episode_id
        arcs[episode.flights] = range(len(episode.flights))
    columns = {"episode_id": names[cuts.flight], "arc": arcs[cuts.flight]}
    velocity = dict(zip(VELOCITY, cuts.velocity.T, strict=True))
    return pd.DataFrame({**columns, **velocity, "outlier": cuts.outlier, "error": cuts.error})


def _contact(contact: Contact) -> dict[str, Any]:
    position = dict(zip(POSITION, contact.position, strict=True))
    return {
        "kind": contact.kind,
        "t": contact.time,
        **position,
        "speed_change": contact.speed_change,
    }


def _episode(episode: Episode) -> dict[str, Any]:
    return {
        "start": episode.begun_by.time if episode.begun_by else np.nan,
        "end": episode.ended_by.time if episode.ended_by else np.nan,
        "starts_with": episode.starts_with,
        "ends_with": episode.ends_with,
        "bounces": sum(contact.kind == "table" for contact in episode.contacts),
    }


def _measured(
    rows: list[dict[str, Any]], samples: pd.DataFrame, settings: SegmentSettings
) -> pd.DataFrame:
    """Return the episodes with what their samples tell; those without a contact end with them."""
    table = pd.DataFrame(rows, columns=list(EPISODE_TYPES)).set_index("episode_id", drop=False)
    grouped = samples.groupby("episode_id")
    table["start"] = table["start"].fillna(grouped["t"].first())
    table["end"] = table["end"].fillna(grouped["t"].last())
    table["samples"], table["outliers"] = grouped.size(), grouped["outlier"].sum()
    squares = samples.loc[~samples["outlier"], "error"] ** 2
    table["residual"] = np.sqrt(squares.groupby(samples["episode_id"]).mean())
    table["unbroken"] = table["residual"] < settings.unbroken_residual
    return table.astype(EPISODE_TYPES).reset_index(drop=True)
