"""Every question is asked once, and folds keep recordings whole."""

import numpy as np
import pytest

from pipeline.known_answers.design import DISTORTION, fold_numbers, planted_errors, questions
from pipeline.runtime.errors import InputError
from tests.pipeline.known_answers.made_up import shots


def test_folds_keep_recordings_whole_and_are_as_large_as_can_be():
    some = shots(recordings=8, each=3)
    fold = fold_numbers("lab", some, 3)
    assert all(len(set(fold[some.groups == name])) == 1 for name in set(some.groups))
    assert sorted(np.bincount(fold)) == [6, 9, 9]


def test_too_few_recordings_are_refused():
    with pytest.raises(InputError, match="lab: has shots of 2 recordings, too few for 3 folds"):
        fold_numbers("lab", shots(recordings=2), 3)


def test_errors_have_rising_sizes_in_minimum_detectable_effects():
    limits = {"drag.cd": 0.02, "gravity.g": 0.1}
    names = [one.name for one in questions("lab", 0, limits)]
    assert len(set(names)) == len(names) == 3 * 3
    sizes = {}
    for error in planted_errors(limits):
        sizes.setdefault((error.place, error.identity), []).append(error.value)
    assert sizes["simulator", "gravity.g"] == pytest.approx([0.2, 0.4, 0.8])
    assert all(values == sorted(set(values)) and len(values) == 3 for values in sizes.values())


def test_no_error_is_planted_that_the_shots_cannot_show_or_that_is_implausible():
    planted = [(one.identity, one.size) for one in planted_errors({"wind.x": 1.0})]
    assert [one for one in planted if one[0] != DISTORTION] == [("wind.x", "2x"), ("wind.x", "4x")]
