"""Shots: padding, labels and what is refused."""

import numpy as np
import pytest

from rallygap.models.gap.fit.shots import Shots

TIMES = [np.array([0.0, 0.1, 0.2]), np.array([5.0, 5.1])]
PLACES = [np.arange(9.0).reshape(3, 3), np.arange(6.0).reshape(2, 3)]


def test_padding_repeats_the_last_sample_is_not_valid_and_shots_are_picked_by_mask():
    shots = Shots.from_arrays(TIMES, PLACES, names=["a", "b"], groups=["x", "y"])
    assert shots.valid.tolist() == [[True, True, True], [True, True, False]]
    assert shots.times[1, 2] == 5.1
    assert shots.positions[1, 2].tolist() == [3.0, 4.0, 5.0]
    assert shots.labels.shape == (2, 0, 3)
    picked = shots[np.array([False, True])]
    assert (len(picked), picked.names.tolist(), picked.groups.tolist()) == (1, ["b"], ["y"])


def test_a_label_in_every_row_is_one_measurement_and_rows_without_one_are_dropped():
    repeated = np.tile([1.0, 2.0, 3.0], (3, 1))
    varying, once = np.array([[[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]], [[np.nan] * 3, [1.0, 2.0, 3.0]]])
    shots = Shots.from_arrays(TIMES, PLACES, [repeated, varying])
    assert shots.labelled.tolist() == [[True, False], [True, True]]
    assert shots.label_times[0, 0] == 0.0
    shots = Shots.from_arrays(TIMES, PLACES, [np.full((3, 3), np.nan), once])
    assert shots.labelled.tolist() == [[False], [True]]
    assert shots.label_times[1, 0] == 5.1


@pytest.mark.parametrize(
    ("times", "places", "message"),
    [
        ([0.0, 0.0], np.zeros((2, 3)), "do not rise"),
        ([0.0, 1.0], np.zeros((1, 3)), "2 times and 1 positions"),
        ([0.0, 1.0], np.full((2, 3), np.nan), "not finite"),
        ([], np.zeros((0, 3)), "0 times"),
        ([0.0, 0.01], np.full((2, 3), 1e200), "shot 0 goes beyond 10000 m or 20 s"),
    ],
)
def test_implausible_shots_and_labels_are_refused(times, places, message):
    with pytest.raises(ValueError, match=message):
        Shots.from_arrays([times], [places])
    with pytest.raises(ValueError, match="a spin label of shot 0 is above 100000 rad/s"):
        Shots.from_arrays([[0.0]], [np.zeros((1, 3))], [np.full((1, 3), 1e6)])
