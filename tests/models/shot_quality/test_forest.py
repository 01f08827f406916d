"""Forests learn what was planted, and say as arrays what scikit-learn says, to the last bit."""

import numpy as np
import pytest
from safetensors.numpy import load, save

from models.shot_quality.forest import Forest, _classifier, grown
from models.shot_quality.settings import ForestSettings
from tests.models.shot_quality.planted import SETTINGS, planted


@pytest.fixture(scope="module")
def forest():
    features, wins, _ = planted()
    return grown(features, wins, SETTINGS, 3)


@pytest.mark.parametrize("leaf", [1, 20, 400])
def test_a_forest_says_what_scikit_learn_says_to_the_last_bit(leaf):
    features, wins, _ = planted()
    settings = ForestSettings(trees=5, smallest_leaf=leaf)
    others = np.random.default_rng(9).normal(scale=2.0, size=(500, features.shape[1]))

    ours = grown(features, wins, settings, 3).probabilities(others)

    theirs = _classifier(settings, 3).fit(features, wins).predict_proba(others)[:, 1]
    assert (ours == theirs).all()


@pytest.mark.parametrize("won", [True, False])
def test_where_all_shots_end_alike_the_probability_is_certain(won):
    features, wins, _ = planted(50)
    forest = grown(features, np.full(len(wins), won), SETTINGS, 0)
    assert (forest.probabilities(features) == float(won)).all()


def test_stored_and_loaded_forests_are_the_same_bit_for_bit(forest):
    stored = save(forest.to_arrays())
    loaded = Forest.from_arrays(load(stored))
    features = planted(200, seed=5)[0]
    assert save(loaded.to_arrays()) == stored
    assert (loaded.probabilities(features) == forest.probabilities(features)).all()


def test_the_same_shots_and_seed_grow_the_same_bytes(forest):
    features, wins, _ = planted()
    assert save(grown(features, wins, SETTINGS, 3).to_arrays()) == save(forest.to_arrays())
    assert save(grown(features, wins, SETTINGS, 4).to_arrays()) != save(forest.to_arrays())


def test_a_planted_rule_is_learned(forest):
    features = planted(300, seed=8)[0]
    told = forest.probabilities(features)
    assert told[features[:, 3] > 1].min() > 0.6 > 0.4 > told[features[:, 3] < -1].max()


def test_unlike_is_what_is_beyond_all_training_shots_and_only_that(forest):
    features, _, _ = planted()
    assert not forest.unlike(features).any()
    beyond = features[:1].copy()
    beyond[0, 2] = features[:, 2].max() + 1e-9
    assert np.flatnonzero(forest.unlike(beyond)).tolist() == [2]


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("left", lambda nodes: nodes[:-1], "different lengths"),
        ("right", lambda nodes: np.zeros_like(nodes), "leads to none"),
        ("left", lambda nodes: nodes + 10**6, "leads to none"),
        ("feature", lambda which: which + 9, "a feature that there is not"),
        ("roots", lambda roots: roots - 1, "a feature that there is not"),
        ("share", lambda share: share + 1, "not between 0 and 1"),
        ("low", lambda low: low * np.nan, "no row of finite float64 numbers"),
        ("left", lambda nodes: nodes.astype(float), "no row of finite int64 numbers"),
    ],
)
def test_trees_that_lead_nowhere_are_refused(forest, name, change, said):
    arrays = forest.to_arrays()
    with pytest.raises(ValueError, match=said):
        Forest.from_arrays({**arrays, name: change(arrays[name])})


def test_other_arrays_are_refused(forest):
    with pytest.raises(ValueError, match="a forest has the arrays"):
        Forest.from_arrays({"roots": forest.roots})
