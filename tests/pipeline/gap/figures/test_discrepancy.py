"""The figures of where a gap arises show the numbers they were given."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from rallygap.pipeline.gap.figures.discrepancy import (
    DIRECTIONS,
    PHASE_COLOURS,
    discrepancy_figure,
    growth_figure,
)
from rallygap.pipeline.web.figure_style import MUTED
from tests.pipeline.verdicts import LOCATED


def test_bands_of_the_phases_add_up_to_the_discrepancy():
    axes = discrepancy_figure(LOCATED).figure.axes[0]
    tops = {
        to_hex(band.get_facecolor()[0]): band.get_paths()[0].vertices[:, 1].max()
        for band in axes.collections
    }
    assert [tops[colour] for colour in PHASE_COLOURS.values()] == pytest.approx([6, 9, 12])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), [0, 2, 6, 12])
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [text.rpartition(", ")[2] for text in texts] == ["15 %", "30 %", "55 %"]


def test_means_over_time_are_drawn_in_each_direction():
    lines = discrepancy_figure(LOCATED).figure.axes[1].lines[1:]
    assert [line.get_label() for line in lines] == list(DIRECTIONS)
    np.testing.assert_allclose(lines[2].get_xydata(), [[100, 0], [200, 3], [300, 6]])


def test_growth_has_a_column_a_covariate_and_a_row_a_direction():
    figure = growth_figure(LOCATED).figure
    grid = np.array(figure.axes).reshape(3, 2)
    assert [axes.get_xlabel() for axes in grid[-1]] == [
        "speed at launch (m/s)",
        "direction of play",
    ]
    assert [axes.get_ylabel() for axes in grid[:, 0]] == ["along (mm)", "across (mm)", "up (mm)"]
    for row in range(3):
        points = grid[row, 0].lines[1].get_xydata()
        np.testing.assert_allclose(points, [[5, 0], [7, row + 1], [9, 2 * (row + 1)]])
    names = [label.get_text() for label in grid[-1, 1].get_xticklabels()]
    assert names == ["towards\n−y", "towards\n+y"]


def test_covariates_that_are_not_significant_are_pale():
    grid = np.array(growth_figure(LOCATED).figure.axes).reshape(3, 2)
    assert [axes.lines[1].get_color() == MUTED for axes in grid[0]] == [False, True]
