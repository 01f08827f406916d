"""The figure of detected and missed contacts."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.score_segmentation import (
    LARGEST_ERROR,
    contact_scores_figure,
)

CONTACTS = pd.DataFrame(
    {
        "kind": ["table", "table", "racket", "racket"],
        "speed": [1.0, 2.0, 8.0, 20.0],
        "detected": [True, False, True, True],
        "error": [0.001, np.nan, -0.002, 0.0],
    }
)


@pytest.fixture
def axes():
    return contact_scores_figure(CONTACTS).figure.axes[1]


def test_errors_are_drawn_over_the_speed_in_milliseconds(axes):
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    np.testing.assert_allclose(drawn["racket: speed after it"], [[8, -2], [20, 0]])


def test_missed_contacts_are_crosses_at_their_speed(axes):
    crosses = [line.get_xydata() for line in axes.lines if line.get_marker() == "x"]
    np.testing.assert_allclose(np.concatenate(crosses), [[2.0, -LARGEST_ERROR]])


def test_without_contacts_the_figure_is_empty():
    figure = contact_scores_figure(CONTACTS.iloc[:0]).figure
    assert [len(axes.lines) for axes in figure.axes] == [0, 0]
