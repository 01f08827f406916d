"""Recordings of an arena of any seed, cut into episodes."""

from pathlib import Path

from rallygap.models.arena.truth import Truth
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.params import Params
from rallygap.pipeline.segmentation.cut_recordings import write_episodes
from rallygap.pipeline.sources.gather import gather


def record_arena(params: Params, seed: int, artifacts: Path) -> Truth:
    """Simulate recordings of an arena, cut them, and return the truth behind them.

    Args:
        params: numbers of recordings, and how they are cut and split.
        seed: of physics, cameras, players and splits.
        artifacts: folder for what ``ingest`` and ``segment`` write.
    """
    settings = params.ingest.model_copy(update={"sources": [ARENA]})
    gathered = gather(settings, seed, artifacts / "ingest")
    write_json(artifacts / "ingest" / "manifest.json", gathered.manifest.model_dump(mode="json"))
    write_episodes(artifacts, params.segment, seed)
    assert gathered.truth is not None  # the arena has one
    return Truth.from_dict(gathered.truth)
