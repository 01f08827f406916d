"""Lightning's logger for trainings that share the run of their stage."""

from typing import Any

from lightning.pytorch.loggers.logger import Logger
from lightning.pytorch.utilities.rank_zero import rank_zero_only

from rallygap.pipeline.tracking.live import LiveRun


class SharedRunLogger(Logger):
    """Adds a training's losses and learning rates to a run that others write and end."""

    name = version = None  # of folders, which it does not write

    def __init__(self, live: LiveRun) -> None:
        super().__init__()
        self.live = live

    @rank_zero_only
    def log_metrics(self, metrics: dict[str, float], step: int | None = None) -> None:
        """Add metrics at an optimizer step."""
        self.live.log(metrics, step or 0)

    def log_hyperparams(self, *_: Any, **__: Any) -> None:
        """The run has the parameters of its stage."""
