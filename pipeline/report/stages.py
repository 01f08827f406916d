"""What each stage reports: tables and figures, written below its folder of reports."""

from collections.abc import Callable, Iterable
from functools import partial

from rallygap.pipeline.report import (
    close_gap,
    evaluate_predictor,
    ingest,
    retrain_policy,
    segment,
    shot_quality,
    sim2real,
    sim2sim,
    train_policy,
    train_predictor,
)
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import apply_style
from rallygap.pipeline.web.report_items import ReportItem, Written

Reports = dict[str, Callable[[StageRun], Iterable[ReportItem]]]
PIPELINE: Reports = {
    "ingest": ingest.items,
    "segment": segment.items,
    "score_segmentation": segment.score_items,
    "train_predictor": train_predictor.items,
    "close_gap": close_gap.items,
    "evaluate_predictor": evaluate_predictor.items,
    "train_policy": train_policy.items,
    "sim2sim": sim2sim.items,
    "sim2real": sim2real.items,
    "shot_quality": shot_quality.items,
    "retrain_policy": retrain_policy.items,
}


def write_reports(run: StageRun, reports: Reports) -> dict[str, list[Written]]:
    """Write the tables and figures of stages, in parallel; return them by stage.

    Raises:
        InputError: a stage has not run, or a file of it is broken.
    """
    tasks = [partial(write_report, run, *report) for report in reports.items()]
    return dict(zip(reports, parallel(tasks, "tables and figures"), strict=True))


def write_report(
    run: StageRun, stage: str, items: Callable[[StageRun], Iterable[ReportItem]]
) -> list[Written]:
    """Write the tables and figures of a stage."""
    apply_style()
    written = []
    for item in items(run):
        item.write(run.root / "reports" / stage / item.file)
        written.append(Written(item.kind, item.file, item.title, item.caption))
    return written
