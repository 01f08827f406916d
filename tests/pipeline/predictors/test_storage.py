"""Trained predictors as files: exact round trip, or an error that names the file."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from safetensors.torch import load_file, save_file

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
    network,
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


def damaged(folder, name, content):
    (folder / name).write_bytes(content)


def with_another_network(folder):
    content = json.loads((folder / DESCRIPTION).read_text())
    content["network"]["width"] = 2 * content["network"]["width"]
    damaged(folder, DESCRIPTION, json.dumps(content).encode())


def without_a_tensor(folder):
    weights = load_file(folder / WEIGHTS)
    del weights["network.projection.bias"]
    save_file(weights, folder / WEIGHTS)


def cut_short(folder):
    damaged(folder, WEIGHTS, (folder / WEIGHTS).read_bytes()[:-100])


class Trap:
    """What runs code when it is unpickled."""

    def __reduce__(self):
        return pytest.fail, ("a pickle was opened",)


DAMAGES = {
    "no weights": (lambda folder: (folder / WEIGHTS).unlink(), WEIGHTS, "run the stage"),
    "no description": (
        lambda folder: (folder / DESCRIPTION).unlink(),
        DESCRIPTION,
        "run the stage",
    ),
    "cut short": (cut_short, WEIGHTS, "is not a file of weights"),
    "empty": (lambda folder: damaged(folder, WEIGHTS, b""), WEIGHTS, "is not a file of weights"),
    "pickled": (
        lambda folder: damaged(folder, WEIGHTS, pickle.dumps(Trap())),
        WEIGHTS,
        "is not a file of weights",
    ),
    "another network": (with_another_network, WEIGHTS, "does not fit the network"),
    "no spread": (lambda folder: (folder / SPREAD).unlink(), SPREAD, "run the stage"),
    "a tensor lost": (without_a_tensor, WEIGHTS, "see network.projection.bias"),
    "no JSON": (lambda folder: damaged(folder, DESCRIPTION, b'{"name":'), DESCRIPTION, "not JSON"),
    "other JSON": (lambda folder: damaged(folder, DESCRIPTION, b"{}"), DESCRIPTION, "name"),
}


@pytest.mark.parametrize(("damage", "name", "problem"), DAMAGES.values(), ids=DAMAGES)
def test_what_cannot_be_loaded_is_an_error_that_names_the_file(folder, damage, name, problem):
    damage(folder)
    with pytest.raises(InputError, match=problem) as error:
        load_predictor(folder)
    assert error.value.where == str(folder / name)


def test_saving_that_fails_leaves_the_former_predictor_and_nothing_else(folder, monkeypatch):
    before = {path: path.read_bytes() for path in folder.parent.rglob("*") if path.is_file()}

    def fail(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr("rallygap.pipeline.predictors.storage.write_text", fail)
    with pytest.raises(OSError, match="full"):
        save_predictor(folder, network(seed=1), Spread(), description(name="other"))
    after = {path: path.read_bytes() for path in folder.parent.rglob("*") if path.is_file()}
    assert after == before
