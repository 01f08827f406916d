"""Assignment of recordings to training, validation, test and replay.

A recording is in one split as a whole: its episodes share players, ball and camera errors. The
recordings of a group are ranked by a hash of the seed and their id, so that a recording's rank
does not depend on the others; each split takes the first of those that remain.

A shot is an unbroken episode whose ball reaches the table; tests and replays count shots.
"""

import hashlib
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rallygap.models.segmentation.settings import SplitSettings

# Sets to replay, in the order of reports: kind of shot, and the groups that it is from.
REPLAY_SETS = {
    "stroke_pro": ("stroke", ["pro"]),
    "stroke_uni": ("stroke", ["club", "semi_pro"]),
    "receive": ("serve", ["pro", "club", "semi_pro"]),
}
NOT_REPLAYED = "none"


@dataclass(frozen=True)
class Split:
    """Splits of the episodes; the series are in the order of the table of episodes."""

    split: "pd.Series[str]"  # train, validation, test or replay
    replay_set: "pd.Series[str]"  # stroke_pro, stroke_uni, receive or none
    shortages: list[str]  # a message for each set that has fewer shots than requested


def split(
    episodes: pd.DataFrame, contacts: pd.DataFrame, settings: SplitSettings, seed: int
) -> Split:
    """Assign every recording to one split.

    Args:
        episodes: one row per episode, in the order of time within a recording.
        contacts: of these episodes.
        settings: size of each split.
        seed: of the ranks.
    """
    shots = _shots(episodes, contacts)
    recordings = _recordings(shots, seed)
    splits, shortages = _assignment(recordings, settings)
    shots["split"] = shots["recording_id"].map(splits)
    shots["rank"] = recordings.index.get_indexer(pd.Index(shots["recording_id"]))
    return Split(shots["split"], _replay_sets(shots, settings), shortages)


def recording_groups(ids: "pd.Series[str]") -> "pd.Series[str]":
    """Return the part of recordings' ids between source and name, such as players' level."""
    return ids.str.replace(r"^[^/]*/(?:(.*)/)?[^/]*$", r"\1", regex=True)


def _assignment(
    recordings: pd.DataFrame, settings: SplitSettings
) -> tuple["pd.Series[str]", list[str]]:
    """Return the split of every recording, and messages on sets with too few shots."""
    splits = pd.Series("train", index=recordings.index, dtype="str")
    shortages = []

    def assign(name: str, members: "pd.Series[bool]", kind: str, wanted: int) -> int:
        """Assign recordings to a split until it has enough; return their number of a kind."""
        free = recordings.loc[members & (splits == "train"), kind]
        enough = int(np.searchsorted(free.cumsum(), wanted)) + 1 if wanted > 0 else 0
        taken = free[: min(enough, int(settings.largest_share * members.sum()))]
        splits[taken.index] = name
        return int(taken.sum())

    for replay_set, (kind, groups) in REPLAY_SETS.items():
        members, wanted = recordings["group"].isin(groups), getattr(settings.replay, replay_set)
        # Recordings that are reserved for one set also count for the next.
        kept = recordings.loc[members & (splits == "replay"), kind].sum()
        reserved = kept + assign("replay", members, kind, wanted - kept)
        if members.any() and reserved < wanted:
            shortages.append(f"{replay_set} has {reserved} of {wanted} episodes to replay")
    wanted = settings.test_episodes
    for source, of_source in recordings.groupby("source", sort=True):
        total, assigned = of_source["shot"].sum(), 0
        for group, of_group in of_source.groupby("group", sort=True):
            quota = int(np.ceil(wanted * of_group["shot"].sum() / max(total, 1)))
            here = (recordings["source"] == source) & (recordings["group"] == group)
            assigned += assign("test", here, "shot", quota)
        if assigned < wanted:
            shortages.append(f"{source} has {assigned} of {wanted} shots to test on")
    remaining = recordings[splits == "train"]
    for _, of_group in remaining.groupby(["source", "group"], sort=True):
        splits[of_group.index[: round(settings.validation_share * len(of_group))]] = "validation"
    return splits, shortages


def _shots(episodes: pd.DataFrame, contacts: pd.DataFrame) -> pd.DataFrame:
    """Return which episodes are shots, and which of those can be replayed to a robot.

    These have a stroke at the far end and a bounce on the robot's half.
    """
    shots = episodes[["recording_id", "source"]].copy()
    shots["shot"] = episodes["unbroken"] & (episodes["bounces"] > 0)
    # A serve is the first contact of a ball since its first sample.
    before = episodes.groupby("recording_id")[["starts_with", "bounces"]].shift()
    is_toss = before["starts_with"].isin(["gap", "recording"]) & (before["bounces"] == 0)
    struck = contacts[(contacts["kind"] == "racket") & (contacts["py"] > 0)]["episode_id"]
    landed = contacts[(contacts["kind"] == "table") & (contacts["py"] < 0)]["episode_id"]
    towards_robot = shots["shot"] & episodes["episode_id"].isin(struck[struck.isin(landed)])
    shots["serve"], shots["stroke"] = towards_robot & is_toss, towards_robot & ~is_toss
    return shots


def _recordings(shots: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Return counts of every recording, by rank."""
    ids = shots["recording_id"]
    sources = shots.groupby("recording_id")[["source"]].first()
    recordings = sources.join(shots.groupby(ids)[["shot", "stroke", "serve"]].sum())
    recordings["group"] = recording_groups(recordings.index.to_series())
    names = [f"{seed}/{recording_id}".encode() for recording_id in recordings.index]
    hashes = [hashlib.blake2b(name, digest_size=7).digest() for name in names]
    return recordings.iloc[np.argsort([int.from_bytes(digest) for digest in hashes])]


def _replay_sets(shots: pd.DataFrame, settings: SplitSettings) -> "pd.Series[str]":
    replay_sets = pd.Series(NOT_REPLAYED, index=shots.index, dtype="str")
    kept = shots[shots["split"] == "replay"].sort_values("rank", kind="stable")
    groups = recording_groups(kept["recording_id"])
    for replay_set, (kind, levels) in REPLAY_SETS.items():
        shots_of_kind = kept.index[kept[kind] & groups.isin(levels)]
        replay_sets[shots_of_kind[: getattr(settings.replay, replay_set)]] = replay_set
    return replay_sets
