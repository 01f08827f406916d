"""Measured effects that docs/deviations.md quotes and no table of the documentation has."""

from pathlib import Path

import pandas as pd

from rallygap.pipeline.documentation.cells import read_report, with_interval
from rallygap.pipeline.documentation.transfer_tables import points
from rallygap.pipeline.io.artifacts import read_json

MEASURED = ["isr_ball_prediction", "spindoe", "tt3d"]
ARENA = ["stroke_pro", "stroke_uni", "receive"]
ERRORS = "reports/evaluate_predictor/forecast_error.csv"


def _errors(root: Path, against: str = "measured", bounce: str = "all") -> pd.Series:
    """Return the predictors' mean position errors at 300 ms (mm) on the arena."""
    query = (
        f"set == 'arena' and against == '{against}' and bounce == '{bounce}' "
        "and quantity == 'position' and horizon_ms == 300"
    )
    table = read_report(root, "evaluate_predictor/forecast_error.csv", query)
    errors: pd.Series = table.set_index("predictor")["mean"]
    return errors


def _ends(values: pd.Series, places: int = 0) -> str:
    return f"{values.min():.{places}f} to {values.max():.{places}f}"


def _unbroken(root: Path) -> str:
    sets = read_json(root / "reports/real/segment/metrics.json")
    shares = 100 * pd.Series({name: one["unbroken_share"] for name, one in sets.items()})
    return (
        f"{shares['arena']:.0f} % of the arena's episodes are unbroken, "
        f"{_ends(shares[MEASURED])} % of the measured sets' (`reports/real/segment/metrics.json`)"
    )


def _bounces(root: Path) -> str:
    within, without = (_errors(root, bounce=name) for name in ("with", "without"))
    parts = (
        f"{name} {within[name]:.0f} mm with a bounce and {without[name]:.0f} mm without"
        for name in ("transformer", "oracle")
    )
    return f"{', '.join(parts)} (`{ERRORS}`)"


def _truth(root: Path) -> str:
    measured, true = (_errors(root, name)["transformer"] for name in ("measured", "truth"))
    return (
        f"transformer: {measured:.1f} mm against the measured state, "
        f"{true:.1f} mm against the true state (`{ERRORS}`)"
    )


def _first_window(root: Path) -> str:
    query = "predictor == 'physics' and outcome == 'returns' and protocol == 'first_window'"
    gains = read_report(root, "sim2real/difference.csv", query)
    return (
        "physics from the first window instead of physics at every control step changes returns by "
        f"{points(gains)} (`reports/sim2real/difference.csv`)"
    )


def _reach(root: Path) -> str:
    shots = read_report(root, "sim2real/replayed.csv").set_index("set").loc[ARENA]
    counts = [f"{row.in_reach} of {row.replayed}" for row in shots.itertuples()]
    return f"{', '.join(counts)} are in reach (`reports/sim2real/replayed.csv`)"


def _forest_label(root: Path) -> str:
    query = "protocol == 'every_tick' and predictor in ('physics', 'transformer')"
    rows = read_report(root, "shot_quality/win_probability.csv", query)
    by_predictor = rows.pivot_table("point", ["set", "horizons_ms"], "predictor")
    apart = (by_predictor["transformer"] - by_predictor["physics"]).abs().max()
    return (
        f"by the outcome of the point, medians are {_ends(rows['point'], 2)}, and physics and the "
        f"transformer differ by at most {apart:.2f} (`reports/shot_quality/win_probability.csv`)"
    )


def _precision(root: Path) -> str:
    rows = read_report(root, "costs/precision.csv").set_index("measure")
    position, spin = (
        with_interval(row.difference, row.ci_low, row.ci_high, ".2f")
        for row in (
            rows.loc["position error, 100 to 300 ms (mm)"],
            rows.loc["spin error at 300 ms (rad/s)"],
        )
    )
    return (
        f"16 bits minus 32: {position} mm from 100 to 300 ms and {spin} rad/s at 300 ms "
        "(`reports/costs/precision.csv`)"
    )


BLOCKS = {
    "deviations.unbroken": _unbroken,
    "deviations.bounces": _bounces,
    "deviations.truth": _truth,
    "deviations.first_window": _first_window,
    "deviations.reach": _reach,
    "deviations.forest_label": _forest_label,
    "deviations.precision": _precision,
}
