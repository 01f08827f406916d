"""Trained predictors as files: exact round trip, or an error that names the file."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from safetensors.torch import load, save

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.spread import Spread
from rallygap.pipeline.predictors.storage import (
    CARD,
    DESCRIPTION,
    SPREAD,
    WEIGHTS,
    Learning,
    TrainedPredictor,
    load_predictor,
    read_description,
    save_predictor,
)
from rallygap.pipeline.runtime.errors import InputError
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import (
    BRIEF,
    NETWORKS,
    TINY,
    small_training,
)

ROOT = Path(__file__).parents[3]
LEARNING = Learning(
    episodes=4321, windows=98765, validation_episodes=432, settings=BRIEF, seed=17
)  # fmt: skip


@pytest.fixture(scope="module")
def trained():
    """A network whose normaliser was fitted."""
    return small_training()[0].network


def description(**changes):
    plain = {
        "name": "small_transformer",
        "network": TINY,
        "parameters": 2468,
        "sources": ["arena", "tt3d"],
        "starts_from": None,
        "learning": LEARNING,
    }
    return TrainedPredictor(**{**plain, **changes})


@pytest.fixture
def folder(tmp_path, trained):
    """Where it is saved."""
    save_predictor(tmp_path / "predictor", trained, Spread(), description())
    return tmp_path / "predictor"


@pytest.mark.parametrize("kind", NETWORKS)
def test_a_network_of_every_kind_comes_back(tmp_path, kind):
    trained, shape = small_training(shape=NETWORKS[kind])[0].network, NETWORKS[kind]
    spread = Spread()
    save_predictor(tmp_path / kind, trained, spread, description(network=shape))
    history, _ = observed(noise=0.003)
    saved, loaded = LearnedPredictor(trained, spread), load_predictor(tmp_path / kind)
    np.testing.assert_array_equal(saved.predict(history).states, loaded.predict(history).states)
    np.testing.assert_array_equal(
        saved.predict_with_covariances(history)[1], loaded.predict_with_covariances(history)[1]
    )
    assert read_description(tmp_path / kind).network == shape
    assert f"kind {kind}" in (tmp_path / kind / CARD).read_text()


class Trap:
    """What runs code when it is unpickled."""

    def __reduce__(self):
        return pytest.fail, ("a pickle was opened",)


def with_another_network(text):
    content = json.loads(text)
    content["network"]["width"] = 2 * content["network"]["width"]
    return json.dumps(content).encode()


def without_a_tensor(content):
    weights = load(content)
    del weights["network.projection.bias"]
    return save(weights)


NO_WEIGHTS = "is not a file of weights"


@pytest.mark.parametrize(
    ("name", "damage", "at_fault", "problem"),
    [
        (WEIGHTS, None, WEIGHTS, "run the stage"),
        (DESCRIPTION, None, DESCRIPTION, "run the stage"),
        (SPREAD, None, SPREAD, "run the stage"),
        (WEIGHTS, lambda content: content[:-100], WEIGHTS, NO_WEIGHTS),
        (WEIGHTS, lambda _: b"", WEIGHTS, NO_WEIGHTS),
        (WEIGHTS, lambda _: pickle.dumps(Trap()), WEIGHTS, NO_WEIGHTS),
        (WEIGHTS, without_a_tensor, WEIGHTS, "see network.projection.bias"),
        (DESCRIPTION, with_another_network, WEIGHTS, "does not fit the network"),
        (DESCRIPTION, lambda _: b'{"name":', DESCRIPTION, "not JSON"),
        (DESCRIPTION, lambda _: b"{}", DESCRIPTION, "name"),
    ],
)
def test_what_cannot_be_loaded_is_an_error_that_names_the_file(
    folder, name, damage, at_fault, problem
):
    path = folder / name
    content = path.read_bytes()
    path.unlink()
    if damage is not None:
        path.write_bytes(damage(content))
    with pytest.raises(InputError, match=problem) as error:
        load_predictor(folder)
    assert error.value.where == str(folder / at_fault)
