"""Metrics that reach the open MLflow run while a training works, also from worker processes."""

import sys
import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

PATIENCE = 20.0  # s, that all live metrics of a run may take a process

_spent: dict[str, float] = defaultdict(float)  # s, by run


@dataclass(frozen=True)
class LiveRun:
    """An open run, as a training in any process adds to it.

    A store that fails, or takes longer than ``PATIENCE`` in all, gets no more metrics from this
    process; the warning is left to the end of the run.

    Attributes:
        uri: of the store.
        run_id: of the run.
        name: of the training, the first part of its metrics' names.
    """

    uri: str
    run_id: str
    name: str

    def log(self, metrics: Mapping[str, float], step: int) -> None:
        """Add metrics at a step."""
        if _spent[self.run_id] > PATIENCE:
            return
        started = time.monotonic()
        try:
            import mlflow

            mlflow.set_tracking_uri(self.uri)
            named = {f"{self.name}/{key}": float(value) for key, value in metrics.items()}
            mlflow.log_metrics(named, step=step, run_id=self.run_id, synchronous=True)
        except Exception:
            _spent[self.run_id] = float("inf")
        _spent[self.run_id] += time.monotonic() - started


def live_run(name: str) -> LiveRun | None:
    """The run that is open in this thread, for a training; None where there is none."""
    mlflow = sys.modules.get("mlflow")
    run = mlflow.active_run() if mlflow else None
    return LiveRun(mlflow.get_tracking_uri(), run.info.run_id, name) if mlflow and run else None
