"""Every question is asked once, and folds keep recordings whole."""

import numpy as np
import pytest

from pipeline.known_answers.design import fold_numbers, planted_errors, questions
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


def test_every_fold_has_an_unplanted_question_and_every_error_in_rising_sizes():
    asked = questions("lab", shots(), 3)
    names = [one.name for one in asked]
    assert len(set(names)) == len(names) == 3 * (1 + 14 * 3)
    assert sum(one.error is None for one in asked) == 3
    sizes = {}
    for error in planted_errors(labelled=True):
        sizes.setdefault((error.place, error.identity), []).append(error.value)
    assert all(values == sorted(set(values)) and len(values) == 3 for values in sizes.values())


def test_errors_of_labels_are_planted_only_where_there_are_labels():
    without = {
        one.error.identity for one in questions("lab", shots(labelled=False), 2) if one.error
    }
    within = {one.error.identity for one in questions("lab", shots(), 2) if one.error}
    assert within - without == {"spin_axis_bias.x", "spin_gain.s"}
