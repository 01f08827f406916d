"""The figure of coverage has few lines, and a set without its predictors has all."""

from itertools import product

import pandas as pd
import pytest

from rallygap.pipeline.report.coverage import coverage_figure


def lines(*predictors):
    keys = product(predictors, (0.5, 0.9), (100, 125, 130, 150))
    rows = pd.DataFrame(keys, columns=["predictor", "level", "horizon_ms"])
    figure = coverage_figure(rows.assign(coverage=0.8, size_mm=20.0))
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


@pytest.mark.parametrize(
    ("predictors", "drawn"),
    [
        (["transformer", "physics_c", "tae", "physics_c_with_net"], ["simulator C", "transformer"]),
        (["tae", "gru_tae"], ["TAE", "GRU-TAE"]),
    ],
)
def test_the_main_predictors_are_drawn_where_a_set_has_them(predictors, drawn):
    assert lines(*predictors) == drawn
