"""The paragraphs that answer the questions of the project count what the tables have."""

import pandas as pd

from rallygap.pipeline.documentation.answers import (
    what_naming_buys,
    when_a_learned_predictor_helps,
    when_the_swap_helps,
)
from rallygap.pipeline.io.artifacts import write_csv
from tests.pipeline.experiments.arenas.made_up import ERRORS


def with_tables(root, tables):
    """A repository with tables in its reports."""
    for name, table in tables.items():
        write_csv(root / "reports" / name, table)
    return root


def gains(differences, **columns):
    """Differences of returns, significant where they are above 5 points."""
    small = [0.001 if difference > 0.05 else 0.8 for difference in differences]
    return pd.DataFrame({"difference": differences, "p_holm": small, "outcome": "returns"}).assign(
        **columns
    )


def test_the_swap_is_compared_under_both_protocols(tmp_path):
    parts = [
        gains([0.13, 0.22], protocol="first_window", predictor="transformer"),
        gains([0.07, 0.12], protocol="first_window", predictor="amended"),
        gains([-0.01, 0.02], protocol="every_tick", predictor="transformer"),
        gains([0.0, 0.06], protocol="every_tick", predictor="oracle"),
        gains([0.5], protocol="every_tick", predictor="transformer", outcome="hits"),
    ]
    again = [gains([0.15, 0.17], predictor="physics_c"), gains([0.4], predictor="tae")]
    tables = {"gains": pd.concat(parts), "gains_every_tick": pd.concat(again)}
    root = with_tables(tmp_path, {f"swap_study/{name}.csv": one for name, one in tables.items()})
    found = when_the_swap_helps(root)
    assert "+13 to +22 points (2 of 2 differences significant)" in found
    assert "-1 to +2 points (0 of 2 differences significant)" in found
    assert "+0 to +6 points (1 of 2 differences significant)" in found
    assert "amended simulator by +7 to +12 points (2 of 2 differences significant)" in found
    assert "with simulator C by +15 to +17 points (2 of 2 differences significant)" in found


def test_recordings_are_counted_from_which_networks_err_less(tmp_path):
    means = {
        "transformer": (90.0, 60.0, 40.0),
        "hybrid": (50.0, 40.0, 30.0),
        "amended_imperfect_c": (55.0, 30.0, 28.0),
    }
    curves = [
        pd.DataFrame({"recordings": [10, 100, 1000], "mean": mean}).assign(
            predictor=name, horizon_ms=300
        )
        for name, mean in means.items()
    ]
    columns = {"quantity": "position", "bounce": "all"}
    arena = pd.DataFrame(
        {
            **columns, "set": "arena", "horizon_ms": 300,
            "against": ["measured", "measured", "truth"], "mean": [95.0, 70.0, 99.0],
            "predictor": ["physics_c", "physics_c_with_net", "physics_c"],
        }
    )  # fmt: skip
    real = {
        **columns, "set": "tt3d", "horizon_ms": 200, "mean": [70.0, 99.0],
        "predictor": ["transformer", "hybrid"],
    }  # fmt: skip
    tables = {
        "learning_curves.csv": pd.concat(curves),
        "evaluate_predictor/forecast_error.csv": arena,
        "real/forecasts.csv": pd.DataFrame(real),
        "arenas/errors.csv": ERRORS,
    }
    found = when_a_learned_predictor_helps(with_tables(tmp_path, tables))
    assert "is 95 mm with simulator C and 70 mm with simulator C and a net" in found
    assert "of a transformer with 100 to 1,000 training recordings" in found
    assert "corrects its forecasts, with any number." in found
    assert "than the transformer with any number of them" in found
    assert "than the hybrid with 100 to 1,000 of them. On" in found
    assert (
        "3.00 times that of the arena's own physics with simulator C and a net, 1.50 with" in found
    )
    assert "70 mm (transformer, `tt3d`)" in found


def test_naming_is_measured_on_arenas_measured_sets_and_policies(tmp_path):
    verdicts = {
        "source": ["tt3d", "tt3d", "spindoe", "arena"],
        "reduction_low_mm": [1.0, -1.0, -3.0, 2.0],
        "reduction_high_mm": [2.0, 1.0, -2.0, 3.0],
    }
    tables = {
        "arenas/errors.csv": ERRORS,
        "real/close_gap/verdicts.csv": pd.DataFrame(verdicts),
        "swap_study/gains_retrained.csv": gains([0.01, 0.07]),
    }
    found = what_naming_buys(with_tables(tmp_path, tables))
    assert "median error of the amended simulator 300 ms ahead is 1.20 times" in found
    assert "amending closes 93 % of the difference between simulator C and the latter" in found
    assert "is above zero in 1 and below zero in 1 of 3 verdicts" in found
    assert "+1 to +7 points (1 of 2 differences significant)" in found
