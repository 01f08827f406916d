"""A policy is the network it was given, whatever it decides beside."""

import numpy as np
import pytest

from rallygap.models.policy.policy import Policy
from tests.models.policy.schooling import drawn_policy


def test_actions_are_those_of_the_network_to_the_bit_alone_and_among_many():
    policy = drawn_policy(width=200)
    rows = np.random.default_rng(2).normal(0, 2, (64, 56)).astype(np.float32)
    (first, after_first), (last, after_last) = policy.layers
    hidden = np.maximum(rows @ first.T + after_first, 0)
    actions = policy.act(rows)
    np.testing.assert_allclose(actions, np.tanh(hidden @ last.T + after_last), atol=1e-5)
    assert actions.dtype == np.float32
    assert (actions > 0).any() and (actions < 0).any()
    for k in (0, 17, 63):
        np.testing.assert_array_equal(policy.act(rows[k : k + 1])[0], actions[k])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weight.0": None}, "no policy has the arrays"),
        ({"bias.0": np.zeros(9)}, "weight.0 does not fit"),
        ({"weight.1": np.zeros((5, 9))}, "weight.1 does not fit"),
        ({"weight.0": np.zeros(())}, "weight.0 does not fit"),
    ],
)
def test_arrays_of_something_else_are_refused(changes, message):
    arrays = {**drawn_policy().to_arrays(), **changes}
    arrays = {name: array for name, array in arrays.items() if array is not None}
    with pytest.raises(ValueError, match=message):
        Policy.from_arrays(arrays)
