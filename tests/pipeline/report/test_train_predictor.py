"""The figure of learning curves shows the numbers it was given."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.train_predictor import training_figure
from rallygap.pipeline.web.figure_style import apply_style

CURVES = pd.DataFrame(
    {
        "predictor": ["transformer"] * 3 + ["transformer_fine_tuned"] * 2,
        "epoch": [1, 2, 3, 1, 2],
        "training": [0.9, 0.5, 0.4, 0.3, 0.2],
        "validation": [1.0, 0.6, 0.45, 0.35, 0.3],
    }
)


TITLES = {"transformer": "transformer", "transformer_fine_tuned": "transformer, fine-tuned"}


@pytest.mark.parametrize(("panel", "name"), enumerate(TITLES))
def test_every_predictor_has_a_panel_with_both_its_curves(panel, name):
    apply_style()
    axes = training_figure(CURVES).axes
    assert len(axes) == 2
    assert axes[panel].get_title(loc="left") == TITLES[name]
    drawn = {line.get_label(): line.get_xydata() for line in axes[panel].lines}
    rows = CURVES[CURVES["predictor"] == name]
    assert set(drawn) == {"training", "validation"}
    for label, points in drawn.items():
        np.testing.assert_array_equal(points, rows[["epoch", label]])
