"""The figures have a mark for every rate, and a number for every gain."""

from itertools import product

import pandas as pd

from rallygap.pipeline.report.swap_study import mechanism_figure, readings_figure

PREDICTORS = ("physics_c", "amended", "oracle", "hybrid", "tae")
OBSERVATIONS, HORIZONS = ("intercept", "strict"), ("115-125", "170-180")


def test_every_rate_is_drawn_under_both_readings():
    keys = product(OBSERVATIONS, HORIZONS, PREDICTORS, ("first_window", "every_tick"))
    names = ["observation", "horizons_ms", "predictor", "protocol"]
    rows = pd.DataFrame(keys, columns=names).assign(
        return_rate=0.8, return_rate_low=0.7, return_rate_high=0.9, balls=150, trainings=3
    )
    figure = readings_figure(rows)
    assert [len(axes.containers) for axes in figure.axes] == [2 * len(PREDICTORS)] * 4


def test_the_gain_of_every_setting_is_written():
    ages = ("40", "80", "160", "320", "first window")
    predictors = ("amended", "transformer", "oracle")
    keys = product(OBSERVATIONS, HORIZONS, ages, (0, 40, 100, 200), (0.0, 0.2), predictors)
    names = ["observation", "horizons_ms", "every_ms", "latency_ms", "label_error", "predictor"]
    rows = pd.DataFrame(keys, columns=names).assign(outcome="returns", difference=0.1, p_holm=0.01)
    rows.loc[rows["every_ms"] == "320", "difference"] = -0.2
    figure = mechanism_figure(rows)
    panels = figure.axes[: len(predictors) * 4]
    assert {axes.images[0].get_clim() for axes in panels} == {(-20, 20)}
    for axes in panels:
        assert sorted(text.get_text() for text in axes.texts) == ["+10"] * 16 + ["-20"] * 4
