"""Trained predictors as files: exact round trip, or an error that names the file."""

import json
import pickle

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
from tests.models.predictors.small_training import BRIEF, NETWORKS, small_training
from tests.pipeline.measured_shots import write_trained


@pytest.fixture
def folder(tmp_path):
    """Where a predictor is saved."""
    write_trained(tmp_path, "small")
    return tmp_path / "artifacts" / "train_predictor" / "small"


@pytest.mark.parametrize("kind", NETWORKS)
def test_a_network_of_every_kind_comes_back(tmp_path, kind):
    shape, spread = NETWORKS[kind], Spread()
    network = small_training(shape=shape)[0].network
    learning = Learning(episodes=43, windows=987, validation_episodes=4, settings=BRIEF, seed=17)
    description = TrainedPredictor(
        name="small", network=shape, parameters=2468, sources=["arena", "tt3d"],
        starts_from=None, learning=learning,
    )  # fmt: skip
    save_predictor(tmp_path, network, spread, description)
    history, _ = observed(noise=0.003)
    saved, loaded = LearnedPredictor(network, spread), load_predictor(tmp_path)
    before, after = (one.predict_with_covariances(history) for one in (saved, loaded))
    np.testing.assert_array_equal(before[0].states, after[0].states)
    np.testing.assert_array_equal(before[1], after[1])
    assert read_description(tmp_path) == description
    assert f"kind {kind}" in (tmp_path / CARD).read_text()


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
