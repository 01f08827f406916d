"""The metrics of a stage in MLflow, and the few that the run of a whole reproduction carries."""

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mlflow.entities import Metric

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.tracking.changed_params import flat
from rallygap.pipeline.tracking.dvc_stages import dvc_stages, upstream

# Patterns of the path of a metric in the stage's metrics.json. Where one name has several values,
# such as the loss of each epoch, the last one counts.
HEADLINES = {
    "ingest": r".*/recordings",
    "segment": r".*/(episodes|median_residual_mm)",
    "score_segmentation": r".*/all/(precision|recall)",
    "train_predictor": r"[^/]+/\d+/validation",
    "close_gap": r".*/removable_closed",
    "evaluate_predictor": r"[^/]+/[^/]+/position/100/mean",
    "train_policy": r".*/return_rate/mean",
    "sim2sim": r".*/difference/mean",
    "sim2real": r".*/every_tick/return_rate",
    "shot_quality": r"scores/.*/forest/roc_auc",
    "retrain_policy": r"replayed/.*/retrained/(physics|transformer)/return_rate",
    "hidden_effects": r"exam/(false_alarm_rate|top1_at_3x|coverage|removable_closed)",
}


def metric_points(metrics: dict[str, Any]) -> Iterator[Metric]:
    """The numbers among nested metrics; a level of whole numbers becomes MLflow's step.

    ``{"position": {"100": {"mean": 3.0}}}`` is ``position/mean`` at step 100, and MLflow draws
    the error over the horizon.
    """
    for keys, value in flat(metrics):
        if isinstance(value, int | float):
            steps = [int(key) for key in keys if key.isdecimal()]
            name = "/".join(key for key in keys if not key.isdecimal())
            yield Metric(name, value, _now(), steps[-1] if steps else 0)


def headline_metrics(stage: str, metrics: dict[str, Any]) -> list[Metric]:
    """The headline metrics of a stage, named after it, one value for each name.

    Args:
        stage: its name.
        metrics: nested, as in its metrics.json.
    """
    pattern = re.compile(HEADLINES.get(stage, r"(?!)"))
    chosen = {
        "/".join([stage, *(key for key in keys if not key.isdecimal())]): value
        for keys, value in flat(metrics)
        if isinstance(value, int | float) and pattern.fullmatch("/".join(keys))
    }
    return [Metric(name, value, _now(), 0) for name, value in chosen.items()]


def upstream_headlines(stage: str) -> Iterator[Metric]:
    """The headline metrics of the stages that a stage depends on, from their present reports.

    DVC may have skipped those stages, so that they have no run of their own.
    """
    stages = dvc_stages(Path("dvc.yaml"))
    for name in sorted(upstream(stages, stage) if stage in stages else ()):
        report = Path("reports", name, "metrics.json")
        if report.exists():
            yield from headline_metrics(name, read_json(report))


def _now() -> int:
    """The time as MLflow counts it, in ms."""
    return round(time.time() * 1000)
