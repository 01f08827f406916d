"""Shots: unbroken paths of measured balls, as the gap workflow takes them."""

from collections.abc import Sequence
from pathlib import Path

from models.gap.fit.shots import Shots
from models.gap.settings import DEFAULTS
from pipeline.io.episodes import MeasuredEpisode, read_episodes
from pipeline.io.source_manifest import read_manifest


def read_training_shots(artifacts: Path) -> dict[str, list[MeasuredEpisode]]:
    """Return the shots of every source in the split that predictors train on.

    Raises:
        InputError: an artefact is missing or broken.
    """
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    episodes = read_episodes(artifacts / "segment", manifest.labelled_once, splits=("train",))
    chosen: dict[str, list[MeasuredEpisode]] = {one.source: [] for one in episodes}
    for one in filter(is_shot, episodes):
        chosen[one.source].append(one)
    return dict(sorted(chosen.items()))


def shots_of(episodes: Sequence[MeasuredEpisode]) -> Shots:
    """Return episodes as the gap workflow takes them."""
    return Shots.from_arrays(
        [one.episode.times for one in episodes],
        [one.episode.positions for one in episodes],
        [one.episode.spins for one in episodes],
        names=[one.episode_id for one in episodes],
        groups=[one.recording_id for one in episodes],
    )


def is_shot(one: MeasuredEpisode) -> bool:
    """Return whether an episode is unbroken, long enough, and touches nothing but the table."""
    times = one.episode.times
    touches = int(one.episode.arc.max())
    bounces = int((one.episode.bounces < times[-1]).sum())
    return one.unbroken and len(times) > DEFAULTS.observed_samples and touches == bounces
