"""The few metrics of each stage that the run of a whole reproduction carries."""

import re
from typing import Any

from mlflow.entities import Metric

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
