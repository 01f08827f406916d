"""Stable-Baselines3's logger as metrics of MLflow."""

from typing import Any

from stable_baselines3.common.logger import KVWriter

from rallygap.pipeline.tracking.live import LiveRun

GROUPS = ("rollout/", "train/")


class MlflowWriter(KVWriter):
    """Writes returns, losses and the learning rate of a training to an open run."""

    def __init__(self, live: LiveRun) -> None:
        self.live = live

    def write(
        self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0
    ) -> None:
        """Add the numbers of an interval, at a control step."""
        metrics = {key: float(value) for key, value in key_values.items() if key.startswith(GROUPS)}
        self.live.log(metrics, step)

    def close(self) -> None:
        """Leave the run open: the stage ends it."""
