"""Lightning's logger for MLflow, for trainings that share the run of their stage."""

from collections.abc import Mapping

from lightning.pytorch.loggers import MLFlowLogger

from rallygap.pipeline.tracking.live import LiveRun


class SharedRunLogger(MLFlowLogger):
    """Adds a training's losses and learning rates to a run that others write and end.

    Args:
        live: the run. A store that fails costs metrics, but no training.
    """

    LOGGER_JOIN_CHAR = "/"  # MLflow groups charts by the part before it

    def __init__(self, live: LiveRun) -> None:
        super().__init__(tracking_uri=live.uri, run_id=live.run_id, prefix=live.name)
        self.live = live
        self._initialized = True  # or Lightning would ask the store for the run

    def log_metrics(self, metrics: Mapping[str, float], step: int | None = None) -> None:
        """Add metrics at an optimizer step."""
        self.live.patiently(lambda _: super(SharedRunLogger, self).log_metrics(metrics, step))

    def finalize(self, status: str = "success") -> None:
        """Leave the run open: the stage ends it."""
