"""The figure of all measured balls."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.report.measured_balls import (
    DRAWN_BALLS,
    DRAWN_LAUNCHES,
    DRAWN_RUN,
    drawn_rows,
    measured_balls_figure,
)

BALLS = pd.DataFrame([[0.1, 1.0, 0.3], [0.2, -1.0, 0.4]], columns=POSITION_COLUMNS)


def points(axes):
    (drawn,) = [line for line in axes.lines if line.get_marker() == "."]
    return np.column_stack(drawn.get_data())


def test_a_source_is_drawn_from_the_side_and_from_above():
    side, above = measured_balls_figure({"lab": BALLS}).axes

    assert points(side).tolist() == [[1.0, 0.3], [-1.0, 0.4]]
    assert points(above).tolist() == [[1.0, 0.1], [-1.0, 0.2]]
    assert side.get_title(loc="left") + side.get_title() == "lab, from the side"


def test_of_many_launches_an_even_choice_is_drawn():
    chosen = drawn_rows(10 * DRAWN_LAUNCHES, launches=True)

    assert len(chosen) == DRAWN_LAUNCHES
    assert (chosen[0], chosen[-1]) == (0, 10 * DRAWN_LAUNCHES - 1)
    assert set(np.diff(chosen)) <= {10, 11}


def test_of_many_balls_an_even_choice_of_runs_is_drawn():
    chosen = drawn_rows(10 * DRAWN_BALLS, launches=False)

    starts, within = chosen.reshape(-1, DRAWN_RUN)[:, 0], chosen.reshape(-1, DRAWN_RUN)
    assert len(chosen) == DRAWN_BALLS
    assert (np.diff(within) == 1).all()
    assert (chosen[0], chosen[-1]) == (0, 10 * DRAWN_BALLS - 1)
    assert np.ptp(np.diff(starts)) <= 1


@pytest.mark.parametrize("rows", [1, DRAWN_BALLS, DRAWN_BALLS + 1])
def test_rows_are_drawn_once_each(rows):
    chosen = drawn_rows(rows, launches=False)

    assert len(set(chosen)) == len(chosen) == min(rows, DRAWN_BALLS)
