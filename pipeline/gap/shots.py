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
    chosen: dict[str, list[MeasuredEpisode]] = {member.source: [] for member in episodes}
    for member in filter(is_shot, episodes):
        chosen[member.source].append(member)
    return dict(sorted(chosen.items()))


def shots_of(episodes: Sequence[MeasuredEpisode]) -> Shots:
    """Return episodes as the gap workflow takes them."""
    return Shots.from_arrays(
        [member.episode.times for member in episodes],
        [member.episode.positions for member in episodes],
        [member.episode.spins for member in episodes],
        names=[member.episode_id for member in episodes],
        groups=[member.recording_id for member in episodes],
    )


def is_shot(member: MeasuredEpisode) -> bool:
    """Return whether an episode is unbroken, long enough, and touches nothing but the table."""
    return why_left_out(member) is None


def why_left_out(member: MeasuredEpisode) -> str | None:
    """Return why an episode is no shot, in words that follow a count; ``None`` for a shot."""
    times = member.episode.times
    if len(times) <= DEFAULTS.observed_samples:
        return "too short"
    if not member.unbroken:
        return "broken"
    touches = int(member.episode.arc.max())
    bounces = int((member.episode.bounces < times[-1]).sum())
    return None if touches == bounces else "touching more than the table"
