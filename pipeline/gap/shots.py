"""Shots: unbroken paths of measured balls, as the gap workflow takes them.

A ball that touches something else than the table is a shot up to there.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.settings import DEFAULTS
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.source_manifest import read_manifest


@dataclass(frozen=True)
class SourceShots:
    """What a source has for the gap workflow.

    Attributes:
        members: its shots.
        left_out: episodes that are no shots, counted by reason.
        nets: its contacts with the net.
    """

    members: list[MeasuredEpisode]
    left_out: dict[str, int]
    nets: NetContacts


def read_training_shots(artifacts: Path) -> dict[str, SourceShots]:
    """Return the shots of every source in the split that predictors train on.

    Raises:
        InputError: an artefact is missing or broken.
    """
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    episodes = read_episodes(artifacts / "segment", manifest.labelled_once, splits=("train",))
    sources = sorted({member.source for member in episodes})
    return {
        source: source_shots([member for member in episodes if member.source == source])
        for source in sources
    }


def source_shots(episodes: Sequence[MeasuredEpisode]) -> SourceShots:
    """Return the shots among the episodes of a source, and its contacts with the net."""
    members, reasons = [], []
    for member in episodes:
        part = member.between(-np.inf, member.touched.min(initial=np.inf))
        if len(part.episode.times) <= DEFAULTS.observed_samples:
            reasons.append("too short")
        elif not part.unbroken:
            reasons.append("broken")
        else:
            members.append(part)
    return SourceShots(members, dict(Counter(sorted(reasons))), net_contacts(episodes))


def shots_of(members: Sequence[MeasuredEpisode]) -> Shots:
    """Return parts of episodes as the gap workflow takes them."""
    return Shots.from_arrays(
        [member.episode.times for member in members],
        [member.episode.positions for member in members],
        [member.episode.spins for member in members],
        names=[member.episode_id for member in members],
        groups=[member.recording_id for member in members],
    )


def net_contacts(episodes: Sequence[MeasuredEpisode]) -> NetContacts:
    """Return the contacts with the net in unbroken episodes: the arc before each and the arc after.

    Contacts after which the path cannot be known, since an arc is too short, are left out.
    """
    before, after = [], []
    for member in episodes:
        contacts = np.concatenate([member.episode.bounces, member.touched])
        for moment in member.nets if member.unbroken else ():
            start = contacts[contacts < moment].max(initial=-np.inf)
            end = contacts[contacts > moment].min(initial=np.inf)
            arcs = member.between(start, moment), member.between(moment, end)
            if min(len(arc.episode.times) for arc in arcs) >= DEFAULTS.net.min_samples:
                before.append(arcs[0])
                after.append(arcs[1])
    return NetContacts(shots_of(before), shots_of(after))
