"""Forests as files: their trees (safetensors) and what they belong to (JSON); never a pickle."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict
from safetensors import SafetensorError
from safetensors.numpy import load, save

from models.shot_quality.forest import Forest
from models.shot_quality.settings import ForestSettings
from models.shot_quality.shots import FEATURES
from pipeline.io.artifacts import read_as, replacing_folder, write_json
from pipeline.runtime.errors import InputError

TREES, DESCRIPTION = "trees.safetensors", "forest.json"


class TrainedForest(BaseModel):
    """What a forest's trees belong to.

    Attributes:
        features: that shots are told by, in their order.
        shots: that it was trained on.
        matches: in which these were played.
        settings: of the forest.
        seed: of its draws.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    features: tuple[str, ...] = FEATURES
    shots: int
    matches: int
    settings: ForestSettings
    seed: int


def save_forest(folder: Path, forest: Forest, description: TrainedForest) -> None:
    """Write a forest; the same trees give the same bytes."""
    with replacing_folder(folder) as temporary:
        (temporary / TREES).write_bytes(save(forest.to_arrays()))
        write_json(temporary / DESCRIPTION, description.model_dump(mode="json"))


def load_forest(folder: Path) -> tuple[Forest, TrainedForest]:
    """Read a forest and what it belongs to.

    Raises:
        InputError: a file is missing or broken.
    """
    description = read_as(folder / DESCRIPTION, TrainedForest, "shot_quality")
    path = folder / TREES
    try:
        forest = Forest.from_arrays(load(path.read_bytes()))
    except FileNotFoundError:
        raise InputError(path, "there is no such file; run the stage shot_quality") from None
    except (OSError, SafetensorError, ValueError, KeyError) as error:
        raise InputError(path, f"is not a file of trees: {error}") from None
    if len(forest.low) != len(description.features):
        raise InputError(path, f"does not fit {DESCRIPTION}: other features")
    return forest, description
