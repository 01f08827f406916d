"""A digest of recordings: of all that is known of their episodes."""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import fields
from typing import Any

import numpy as np

from rallygap.pipeline.io.episodes import MeasuredEpisode


def episodes_digest(episodes: Iterable[MeasuredEpisode]) -> str:
    """Return SHA-256 over names, times, positions, spins, contacts and all else of episodes."""
    digest = hashlib.sha256()
    for one in episodes:
        for value in _values(one):
            content = value.tobytes() if isinstance(value, np.ndarray) else str(value).encode()
            digest.update(content)
    return digest.hexdigest()


def _values(one: MeasuredEpisode) -> Iterator[Any]:
    """Yield what is known of an episode and of its samples."""
    for part in (one, one.episode):
        yield from (getattr(part, field.name) for field in fields(part) if field.name != "episode")
