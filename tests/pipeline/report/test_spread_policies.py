"""The figure has a column for each set, and every kind of policy with every predictor."""

import pandas as pd

from rallygap.pipeline.report.spread_policies import LABELS, spread_policies_figure

ENDS = {"return_rate": 0.8, "return_rate_low": 0.75, "return_rate_high": 0.85}


def test_every_rate_is_drawn():
    rows = [
        {"set": name, "predictor": predictor, "policy": policy, "balls": 200, **ENDS}
        for name in ("games", "launches")
        for predictor in ("physics", "oracle", "transformer")
        for policy in LABELS
        if (name, predictor) != ("launches", "oracle")
    ]
    left, right = spread_policies_figure(pd.DataFrame(rows)).axes
    for axes, predictors in ((left, 3), (right, 2)):
        drawn = [len(one.lines[0].get_xdata()) for one in axes.containers]
        assert drawn == [predictors] * len(LABELS)
