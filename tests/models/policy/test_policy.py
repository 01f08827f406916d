"""A policy is the network it was given, whatever it decides beside."""

import numpy as np
import pytest

from rallygap.models.policy.policy import Policy
from tests.models.policy.schooling import drawn_policy, same


def observations(count=7, size=56):
    return np.random.default_rng(2).normal(0, 2, (count, size)).astype(np.float32)


def test_actions_are_those_of_the_network_to_the_bit_alone_and_among_many():
    policy, rows = drawn_policy(width=200), observations(64)
    (first, after_first), (last, after_last) = policy.layers
    hidden = np.maximum(rows @ first.T + after_first, 0)

    actions = policy.act(rows)

    np.testing.assert_allclose(actions, np.tanh(hidden @ last.T + after_last), atol=1e-5)
    assert actions.dtype == np.float32
    assert (actions > 0).any() and (actions < 0).any()
    for k in (0, 17, 63):
        np.testing.assert_array_equal(policy.act(rows[k : k + 1])[0], actions[k])


def test_a_policy_comes_back_from_its_arrays():
    arrays = drawn_policy().to_arrays()

    assert set(arrays) == {"weight.0", "weight.1", "bias.0", "bias.1"}
    assert same(Policy.from_arrays(arrays), drawn_policy())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weight.0": None}, "no policy has the arrays"),
        ({"weight.2": np.zeros((5, 5)), "bias.2": None}, "no policy has the arrays"),
        ({"bias.0": np.zeros(9)}, "weight.0 does not fit"),
        ({"weight.1": np.zeros((5, 9))}, "weight.1 does not fit"),
        ({"bias.1": np.zeros((5, 1))}, "weight.1 does not fit"),
        ({"weight.0": np.zeros(())}, "weight.0 does not fit"),
    ],
)
def test_arrays_of_something_else_are_refused(changes, message):
    arrays = {**drawn_policy().to_arrays(), **changes}
    arrays = {name: array for name, array in arrays.items() if array is not None}

    with pytest.raises(ValueError, match=message):
        Policy.from_arrays(arrays)
