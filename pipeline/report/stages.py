"""What each stage reports: tables and figures, written below its folder of reports."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

from rallygap.pipeline.report import (
    arenas,
    close_gap,
    evaluate_predictor,
    exam,
    ingest,
    learning_curves,
    paper_network,
    real_forecasts,
    retrain_policy,
    score_segmentation,
    segment,
    shot_quality,
    sim2real,
    sim2sim,
    spread_policies,
    swap_study,
    train_policy,
    train_predictor,
)
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import apply_style
from rallygap.pipeline.web.report_items import ReportItem, Written

Reports = dict[str, Callable[[StageRun], Iterator[ReportItem]]]
PIPELINE: Reports = {
    "ingest": ingest.items,
    "segment": segment.items,
    "score_segmentation": score_segmentation.items,
    "train_predictor": train_predictor.items,
    "close_gap": close_gap.items,
    "evaluate_predictor": evaluate_predictor.items,
    "train_policy": train_policy.items,
    "sim2sim": sim2sim.items,
    "sim2real": sim2real.items,
    "shot_quality": shot_quality.items,
    "retrain_policy": retrain_policy.items,
}


EXPERIMENTS: Reports = {
    "exam": exam.items,
    "arenas": arenas.items,
    "learning_curves": learning_curves.items,
    "real_forecasts": real_forecasts.items,
    "swap_study": swap_study.items,
    "spread_policies": spread_policies.items,
    "paper_network": paper_network.items,
}


def write_reports(run: StageRun, stages: Iterable[str]) -> dict[str, list[Written]]:
    """Write the tables and figures of stages, in parallel; return them by stage.

    Raises:
        InputError: a stage has not run, or a file of it is broken.
    """
    names = list(stages)
    tasks = [partial(write_report, run, stage) for stage in names]
    return dict(zip(names, parallel(tasks, "tables and figures"), strict=True))


def write_report(run: StageRun, stage: str) -> list[Written]:
    """Write the tables and figures of a stage."""
    apply_style()
    written = []
    for item in (PIPELINE | EXPERIMENTS)[stage](run):
        item.write(run.root / "reports" / stage / item.file)
        written.append(Written(item.kind, item.file, item.title, item.caption))
    return written
