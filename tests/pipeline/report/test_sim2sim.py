"""The figure of the sim-to-sim experiment shows the numbers it was given."""

from itertools import product

import numpy as np
import pandas as pd

from rallygap.pipeline.report.sim2sim import COLOURS, PROTOCOLS, sim2sim_figure
from rallygap.pipeline.web.figure_style import apply_style

SIMULATORS = ["imperfect_a", "imperfect_b", "imperfect_c"]
HORIZONS = ["115-125", "170-180"]


def made_up(protocols=tuple(PROTOCOLS), policies=2):
    """Return rates of made-up policies, no two of them alike."""
    settings = product(protocols, SIMULATORS, HORIZONS, COLOURS)
    rows = pd.DataFrame(settings, columns=["protocol", "simulator", "horizons_ms", "predictor"])
    rate = 0.95 - 0.035 * np.arange(len(rows))
    each = [[share + 0.01 * k for k in range(policies)] for share in rate]
    ends = {"ci_low": rate - 0.04, "ci_high": rate + 0.03}
    return rows.assign(return_rate=rate, **ends, per_seed=each, balls=300, trainings=policies)


def bars(axes, predictor):
    colour = COLOURS[predictor]
    return [bar for bar in axes.patches if matches(bar.get_facecolor(), colour)]


def matches(colour, code):
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour[:3]) == code


def test_every_protocol_has_a_panel_with_two_bars_a_simulator_and_horizons():
    apply_style()
    rates = made_up()
    panels = sim2sim_figure(rates).axes
    titles = [axes.get_title(loc="left") for axes in panels]
    assert titles == list(PROTOCOLS.values())
    for axes, (_, panel) in zip(panels, rates.groupby("protocol"), strict=True):
        for predictor, rows in panel.groupby("predictor"):
            drawn = [bar.get_height() for bar in bars(axes, predictor)]
            np.testing.assert_allclose(drawn, 100 * rows["return_rate"])


def test_whiskers_are_the_interval():
    rates = made_up(["first_state"])
    axes = sim2sim_figure(rates).axes[0]
    drawn = [path.vertices[:, 1] for lines in axes.collections for path in lines.get_paths()]
    rows = pd.concat([part for _, part in rates.groupby("predictor", sort=False)])
    np.testing.assert_allclose(drawn, 100 * rows[["ci_low", "ci_high"]])


def test_the_legend_says_how_many_shots_and_trainings_a_rate_is_of():
    for policies, words in ((1, "300 shots, 1 training"), (2, "300 shots, 2 trainings")):
        (legend,) = sim2sim_figure(made_up(policies=policies)).legends
        assert f"95 % interval, {words}" in [text.get_text() for text in legend.get_texts()]
