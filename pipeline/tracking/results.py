"""What a run leaves to MLflow: metrics, data sets that it read, figures and trained models."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class InputData:
    """A data set that a stage read: its file or folder, number of rows, and MD5 of its content."""

    name: str
    source: str
    rows: int
    digest: str


@dataclass(frozen=True)
class TrainedModel:
    """A model that a stage trained, to be registered under a name of its own.

    Attributes:
        name: of the registered model.
        folder: with its weights and description; ``served_model`` loads it.
        measure: what its score is, such as ``validation_loss``.
        score: of the measure.
        smaller_is_better: of the score.
        data: digest of what the score was measured on; scores of other data do not compare.
    """

    name: str
    folder: Path
    measure: str
    score: float
    smaller_is_better: bool
    data: str


@dataclass(frozen=True)
class Results:
    """What a run leaves: nested metrics, data sets that it read, paths of its figures, models."""

    metrics: dict[str, Any] = field(default_factory=dict)
    inputs: list[InputData] = field(default_factory=list)
    figures: list[Path] = field(default_factory=list)
    models: list[TrainedModel] = field(default_factory=list)
