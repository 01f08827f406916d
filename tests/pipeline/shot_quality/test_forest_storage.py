"""Forests as files: they come back bit for bit, or one error names the file."""

import json

import numpy as np
import pytest
from safetensors.numpy import save

from models.shot_quality.forest import grown
from models.shot_quality.shots import FEATURES
from pipeline.runtime.errors import InputError
from pipeline.shot_quality.forest_storage import (
    DESCRIPTION,
    TREES,
    TrainedForest,
    load_forest,
    save_forest,
)
from tests.models.shot_quality.planted import SETTINGS, planted

DESCRIBED = TrainedForest(shots=600, matches=100, settings=SETTINGS, seed=0)


@pytest.fixture(scope="module")
def forest():
    features, wins, _ = planted()
    return grown(features, wins, SETTINGS, 0)


def test_a_forest_comes_back_as_it_was_saved(forest, tmp_path):
    save_forest(tmp_path / "one", forest, DESCRIBED)
    loaded, described = load_forest(tmp_path / "one")
    save_forest(tmp_path / "other", loaded, described)

    assert described == DESCRIBED and described.features == FEATURES
    features = planted(100, seed=4)[0]
    assert (loaded.probabilities(features) == forest.probabilities(features)).all()
    assert {path.name for path in (tmp_path / "one").iterdir()} == {TREES, DESCRIPTION}
    for name in (TREES, DESCRIPTION):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "other" / name).read_bytes()


def described_with(**changes):
    return json.dumps({**DESCRIBED.model_dump(mode="json"), **changes}).encode()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        (TREES, None, "there is no such file; run the stage shot_quality"),
        (TREES, b"", "is not a file of trees"),
        (TREES, save({"roots": np.zeros(3)}), "is not a file of trees: a forest has the arrays"),
        (DESCRIPTION, None, "there is no such file"),
        (DESCRIPTION, described_with(seed="x"), "seed.*dvc repro -f shot_quality"),
        (DESCRIPTION, described_with(features=["vx"]), None),
    ],
)
def test_a_broken_file_is_one_error_that_names_it(forest, tmp_path, name, content, said):
    save_forest(tmp_path / "forest", forest, DESCRIBED)
    path = tmp_path / "forest" / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)

    with pytest.raises(InputError, match=said or "does not fit forest.json") as error:
        load_forest(path.parent)

    if said:
        assert str(error.value).startswith(str(path))
