"""The figure of the loop shows the rates it was given."""

import numpy as np
import pandas as pd

from rallygap.pipeline.report.retrain_policy import retraining_figure
from rallygap.pipeline.web.figure_style import apply_style

PAIRS = [("original", "physics"), ("original", "oracle"), ("retrained", "amended")]


def made_up():
    keys = [("arena", ahead, *pair) for ahead in ("115-125", "170-180") for pair in PAIRS]
    rows = pd.DataFrame(keys, columns=["set", "horizons_ms", "policy", "predictor"])
    rate = 0.5 + 0.05 * np.arange(len(rows))
    ends = {"return_rate_low": rate - 0.1, "return_rate_high": rate + 0.1}
    return rows.assign(balls=20, trainings=1, return_rate=rate, **ends)


def test_every_policy_and_predictor_has_a_bar_in_the_panel_of_its_horizons():
    apply_style()
    figure = retraining_figure(made_up())
    widths = [[bar.get_width() for bar in axes.patches] for axes in figure.axes]
    np.testing.assert_allclose(widths, [[50, 55, 60], [65, 70, 75]])
    names = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert names == [
        "original policy, own simulator",
        "original policy, oracle",
        "retrained policy, own simulator amended",
    ]
    assert (
        figure.axes[1].get_title(loc="left") == "arena, horizons 170–180 ms, 20 shots, 1 training"
    )
