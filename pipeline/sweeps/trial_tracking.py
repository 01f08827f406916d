"""Trials in MLflow: each a run, under one parent a study."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from optuna import TrialPruned

from pipeline.params import Params
from pipeline.runtime.provenance import Provenance
from pipeline.sweeps.plan import Plan
from pipeline.tracking.recording import description, recording


@dataclass
class TrialRecord:
    """What a trial leaves behind: its score after every epoch or leg."""

    scores: dict[int, float] = field(default_factory=dict)


@contextmanager
def recorded_trial(plan: Plan, study: str, number: int, params: Params) -> Iterator[TrialRecord]:
    """Record the trial that is done in this block."""
    stage = plan.settings.stage
    command = f"rallygap sweep {plan.name}"
    own = params.model_dump(mode="json", include={"seed", stage})
    start = description(f"trial {number}", Provenance(command, study), own)
    start |= {"reproduction": study, "parent": command}
    # A trial is none of DVC's stages, whatever it trains.
    tags = {name: tag for name, tag in start["tags"].items() if not name.startswith("dvc.")}
    start["tags"] = {**tags, "rallygap.study": study, "rallygap.trial": str(number)}
    record = TrialRecord()
    name = plan.settings.score.replace(" ", "_")

    def results() -> dict[str, Any]:
        return {"metrics": {name: {str(step): score for step, score in record.scores.items()}}}

    given_up = None
    with recording(start, results):
        try:
            yield record
        except TrialPruned as pruned:  # which is an end as good as any
            given_up = pruned
    if given_up is not None:
        raise given_up
