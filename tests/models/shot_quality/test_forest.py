"""The forest finds a known rule and reports the range of its training shots."""

import numpy as np
import pytest

from rallygap.models.shot_quality.forest import Forest
from tests.models.shot_quality.planted import SETTINGS, planted


@pytest.fixture(scope="module")
def forest():
    return Forest(*planted()[:2], SETTINGS, 3)


@pytest.mark.parametrize("won", [True, False])
def test_with_a_single_outcome_the_probability_is_certain(won):
    features, wins, _ = planted(50)
    forest = Forest(features, np.full(len(wins), won), SETTINGS, 0)
    assert (forest.probabilities(features) == float(won)).all()


def test_a_known_rule_is_found_and_no_shots_have_no_probability(forest):
    features = planted(300, seed=8)[0]
    probabilities = forest.probabilities(features)
    assert probabilities[features[:, 3] > 1].min() > 0.6
    assert probabilities[features[:, 3] < -1].max() < 0.4
    assert forest.probabilities(features[:0]).shape == (0,)


def test_out_of_range_is_what_lies_beyond_all_training_shots(forest):
    features, _, _ = planted()
    assert not forest.out_of_range(features).any()
    beyond = features[:1].copy()
    beyond[0, 2] = features[:, 2].max() + 1e-9
    assert np.flatnonzero(forest.out_of_range(beyond)).tolist() == [2]
