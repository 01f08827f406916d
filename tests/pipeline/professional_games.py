"""Games of professionals as ingest and segment leave them, and what truly happened in them."""

from types import SimpleNamespace

import numpy as np
import pandas as pd

from rallygap.models.arena.cameras import Cameras
from rallygap.models.arena.games import games
from rallygap.models.arena.truth import draw_truth
from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.io.schemas import POINTS, POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.sources.adapters.arena import KINDS
from rallygap.stages.segment import segment
from tests.pipeline.measured_shots import source_record

TRUTH = draw_truth(5)


def played_games(matches):
    """Recordings of some matches."""
    systematic = {"field": TRUTH.camera_field, "arc_spin_noise": TRUTH.arc_spin_noise}
    cameras = Cameras(0.003, 0.05, 0.02, 0.005, TRUTH.slow_error, 0.005, **systematic)
    random = np.random.default_rng(4)
    return list(games(TRUTH, cameras, "pro", range(matches), random))


def write_games(root, recordings):
    """Write recordings as ingest would, and cut them up."""
    ingested = root / "artifacts" / "ingest"
    write_table(ingested / "recordings.parquet", pd.concat(map(_samples, recordings)))
    write_table(ingested / "points.parquet", pd.concat(map(points_table, recordings)))
    record = {**source_record("arena", "per_sample"), "kind": KINDS}
    write_json(ingested / "manifest.json", {"sources": {"arena": record}})
    segment(StageRun("segment", root, SimpleNamespace(segment=SegmentSettings(), seed=0)))


def points_table(recording):
    """The umpire's record of a recording."""
    columns = list(POINTS.columns)[1:]
    rows = [[getattr(point, name) for name in columns] for point in recording.points]
    table = pd.DataFrame(rows, columns=columns)
    table.insert(0, "recording_id", f"arena/{recording.name}")
    return table


def _samples(recording):
    values = np.column_stack([recording.times, recording.positions, recording.spins])
    table = pd.DataFrame(values, columns=["t", *POSITION_COLUMNS, *SPIN_COLUMNS])
    table.insert(0, "recording_id", f"arena/{recording.name}")
    return table
