"""Folds keep recordings whole."""

import numpy as np
import pytest

from experiments.folds import fold_numbers
from rallygap.pipeline.runtime.errors import InputError


def test_folds_keep_recordings_whole_and_are_as_large_as_can_be():
    recordings = np.repeat([f"r{k}" for k in range(8)], 3)
    fold = fold_numbers("lab", recordings, 3)
    assert all(len(set(fold[recordings == name])) == 1 for name in set(recordings))
    assert sorted(np.bincount(fold)) == [6, 9, 9]


def test_too_few_recordings_are_refused():
    with pytest.raises(InputError, match="lab: has shots of 2 recordings, too few for 3 folds"):
        fold_numbers("lab", np.array(["a", "b", "b"]), 3)
