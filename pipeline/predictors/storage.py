"""Trained predictors as files: weights (safetensors), description (JSON) and model card."""

from pathlib import Path
from typing import Any

import torch
from pydantic import BaseModel, ConfigDict, model_validator
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from rallygap.models.predictors.learned import ForecastNetwork, LearnedPredictor, build_network
from rallygap.models.predictors.settings import HybridSettings, NetworkSettings, TrainingSettings
from rallygap.models.predictors.spread import Spread
from rallygap.pipeline.io.artifacts import read_as, replacing_folder, write_json, write_text
from rallygap.pipeline.io.markdown import markdown_page
from rallygap.pipeline.io.simulators import load_simulator, simulator_yaml
from rallygap.pipeline.params import with_current_keys
from rallygap.pipeline.runtime.errors import InputError

WEIGHTS, SPREAD = "weights.safetensors", "spread.safetensors"
DESCRIPTION, CARD = "predictor.json", "MODEL_CARD.md"
SIMULATOR = "simulator.yaml"  # of a hybrid
_TEMPLATE = Path(__file__).parent / "templates" / "model_card.md"


class Learning(BaseModel):
    """How a predictor was trained.

    Attributes:
        episodes: training episodes.
        windows: training windows, over all epochs.
        validation_episodes: for the validation loss alone.
        settings: of training.
        seed: of every random draw.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    episodes: int
    windows: int
    validation_episodes: int
    settings: TrainingSettings
    seed: int


class TrainedPredictor(BaseModel):
    """The description of a trained predictor.

    Attributes:
        name: in reports.
        network: its settings.
        parameters: number of trained parameters.
        sources: data sets that it was trained on.
        starts_from: the predictor that was fine-tuned, if any.
        learning: how it was trained.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    network: NetworkSettings
    parameters: int
    sources: list[str]
    starts_from: str | None
    learning: Learning

    @model_validator(mode="before")
    @classmethod
    def _current_keys(cls, content: Any) -> Any:
        return with_current_keys(content)


def save_predictor(
    folder: Path, network: ForecastNetwork, spread: Spread, description: TrainedPredictor
) -> None:
    """Write a trained predictor; the same weights give the same bytes."""
    content = description.model_dump(mode="json")
    with replacing_folder(folder) as temporary:
        (temporary / WEIGHTS).write_bytes(_weights(network))
        (temporary / SPREAD).write_bytes(_weights(spread))
        if network.simulator is not None:
            write_text(temporary / SIMULATOR, simulator_yaml(network.simulator))
        write_json(temporary / DESCRIPTION, content)
        write_text(temporary / CARD, markdown_page(_TEMPLATE, **content))


def read_description(folder: Path) -> TrainedPredictor:
    """Read the description of a trained predictor.

    Raises:
        InputError: the file is missing or invalid.
    """
    return read_as(folder / DESCRIPTION, TrainedPredictor, "train_predictor")


def load_network(folder: Path) -> ForecastNetwork:
    """Read a trained network.

    Raises:
        InputError: a file is missing or invalid, or the weights do not fit the network.
    """
    described = read_description(folder).network
    hybrid = isinstance(described, HybridSettings)
    simulator = load_simulator(str(folder / SIMULATOR)) if hybrid else None
    with torch.device("meta"):  # allocates nothing, however large the described network is
        planned = build_network(described)
    weights = _checked_weights(folder / WEIGHTS, planned)
    network = build_network(described, simulator)
    network.load_state_dict(weights)
    return network


def load_predictor(folder: Path) -> LearnedPredictor:
    """Read a trained predictor, with the errors of ``load_network``."""
    network, spread = load_network(folder), Spread()
    spread.load_state_dict(_checked_weights(folder / SPREAD, spread))
    return LearnedPredictor(network, spread)


def _weights(module: nn.Module) -> bytes:
    return save({name: value.contiguous().cpu() for name, value in module.state_dict().items()})


def _checked_weights(path: Path, planned: nn.Module) -> dict[str, Tensor]:
    """Read the weights of a module that has been planned."""
    try:
        weights = load(path.read_bytes())
    except FileNotFoundError:
        raise InputError(path, "there is no such file; run the stage train_predictor") from None
    except (OSError, SafetensorError, ValueError, KeyError) as error:
        raise InputError(path, f"is not a file of weights: {error}") from None
    expected = {name: value.shape for name, value in planned.state_dict().items()}
    actual = {name: value.shape for name, value in weights.items()}
    if actual != expected:
        names = sorted(set(actual.items()) ^ set(expected.items()))
        raise InputError(path, f"does not fit the network of {DESCRIPTION}: see {names[0][0]}")
    if not all(value.isfinite().all() for value in weights.values()):
        raise InputError(path, "has values that are not finite; train it again")
    return weights
