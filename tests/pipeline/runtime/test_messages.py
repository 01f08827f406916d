"""An error of input is the same in every process."""

import pickle

import pytest

from rallygap.pipeline.params import ParameterError
from rallygap.pipeline.runtime.errors import InputError

ERROR = InputError("balls.csv", "is not a number", row=3, field="px")


@pytest.mark.parametrize("error", [ERROR, ParameterError([ERROR, InputError("params.yaml", "?")])])
def test_an_error_comes_whole_out_of_a_worker(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)
