"""The few metrics of each stage that the run of a whole reproduction carries."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mlflow.entities import Metric

from pipeline.io.artifacts import read_json
from pipeline.params import read_yaml
from pipeline.tracking.changed_params import flat

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


def headline_metrics(stage: str, metrics: dict[str, Any], timestamp: int) -> list[Metric]:
    """The headline metrics of a stage, named after it.

    Args:
        stage: its name.
        metrics: nested, as in its metrics.json.
        timestamp: in ms.

    Returns:
        One value a name.
    """
    pattern = re.compile(HEADLINES.get(stage, r"(?!)"))
    chosen = {
        "/".join([stage, *(key for key in keys if not key.isdecimal())]): value
        for keys, value in flat(metrics)
        if isinstance(value, int | float) and pattern.fullmatch("/".join(keys))
    }
    return [Metric(name, value, timestamp, 0) for name, value in chosen.items()]


def upstream_headlines(stage: str, timestamp: int) -> Iterator[Metric]:
    """The headline metrics of the stages that a stage depends on, from the reports of today.

    DVC may have skipped those stages, so that they have no run of their own.
    """
    for name in sorted(upstream(read_yaml(Path("dvc.yaml"))["stages"], stage)):
        report = Path("reports", name, "metrics.json")
        if report.exists():
            yield from headline_metrics(name, read_json(report), timestamp)


def upstream(stages: dict[str, Any], stage: str) -> set[str]:
    """The stages that a stage depends on, directly or not; none for what is no stage.

    Args:
        stages: as in dvc.yaml.
        stage: name.
    """
    dependencies = [Path(path) for path in stages.get(stage, {}).get("deps", [])]
    direct = {
        name
        for name, entry in stages.items()
        for listed in entry.get("outs", [])
        for out in map(Path, [listed] if isinstance(listed, str) else listed)
        if any(path == out or path in out.parents or out in path.parents for path in dependencies)
    } - {stage}
    return direct.union(*(upstream(stages, name) for name in direct))
