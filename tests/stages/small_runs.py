"""Runs of the first stages on a few shots of the arena's cannon."""

from types import SimpleNamespace

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.ingest import ingest
from rallygap.stages.segment import segment
from tests.pipeline.sources.made_up import ARENA


def run_ingest(root, folder=None, sources=("arena",), arena=ARENA, seed=0):
    settings = IngestSettings(folder=folder, sources=list(sources), arena=arena)
    run = StageRun("ingest", root, SimpleNamespace(ingest=settings, seed=seed))
    ingest(run)
    return run


def run_segment(root):
    run = StageRun("segment", root, SimpleNamespace(segment=SegmentSettings(), seed=0))
    segment(run)
    return run
