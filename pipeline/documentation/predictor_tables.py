"""Tables of forecast errors and of what predictors cost."""

from pathlib import Path
from typing import Any

from pipeline.documentation.cells import (
    HORIZON_HEADS,
    HORIZONS_MS,
    NONE,
    PREDICTORS,
    read_report,
    with_interval,
)
from pipeline.io.markdown import markdown_table

# Predictors that recordings of a measured set have adapted.
ADAPTED = {
    "physics_literature": "physics, literature",
    "amended": "physics, literature amended",
    "hybrid": "hybrid, fine-tuned",
    "hybrid_on_amended": "hybrid on the amended simulator, fine-tuned",
    "transformer": "transformer, fine-tuned",
}


def position_errors(root: Path, run: str = "", *, arena: bool) -> str:
    """Mean position errors in mm with 95 % intervals, from ``evaluate_predictor``.

    Args:
        root: of the repository.
        run: a kept run, such as ``paper/``; the present reports where empty.
        arena: whether the rows are those of the arena, or of the measured sets.
    """
    query = "against == 'measured' and quantity == 'position' and bounce == 'all'"
    errors = read_report(root, f"{run}evaluate_predictor/forecast_error.csv", query)
    errors = errors[(errors["set"] == "arena") == arena].sort_values("horizon_ms", kind="stable")
    rows = []
    for (name, predictor), some in errors.groupby(["set", "predictor"], sort=False):
        cells = [with_interval(row.mean, row.ci_low, row.ci_high) for row in some.itertuples()]
        rows.append([name, PREDICTORS[predictor], *cells])
    return markdown_table(["set", "predictor", *HORIZON_HEADS], rows)


def errors_by(root: Path, column: str) -> str:
    """Mean and median position errors in mm at 300 ms on the arena, from ``evaluate_predictor``.

    Args:
        root: of the repository.
        column: ``group`` of the recordings, or ``net``: with or without net contact.
    """
    name = f"evaluate_predictor/forecast_error_by_{column}.csv"
    errors = read_report(root, name, "set == 'arena'")
    rows = []
    for predictor, some in errors.groupby("predictor", sort=False):
        cells = _with_medians(some)
        rows.append([PREDICTORS[predictor], *cells])
    return markdown_table(["predictor", *errors[column].unique()], rows)


def _with_medians(rows: Any) -> list[str]:
    """Return the mean of each row with its interval and its median."""
    return [
        f"{with_interval(row.mean, row.ci_low, row.ci_high)}, median {row.median:.0f}"
        for row in rows.itertuples()
    ]


def coverage(root: Path) -> str:
    """Coverage and size of the sets of positions at 300 ms on the arena, and the score."""
    query = "set == 'arena' and horizon_ms == 300"
    table = read_report(root, "evaluate_predictor/coverage.csv", query)
    levels = sorted(table["level"].unique())
    heads = [f"{100 * level:.0f} % sets: coverage (%), radius (mm)" for level in levels]
    rows = []
    for predictor, some in table.groupby("predictor", sort=False):
        cells = [
            f"{100 * row.coverage:.1f} ({100 * row.ci_low:.1f} to {100 * row.ci_high:.1f}), "
            f"{row.size_mm:.0f}"
            for row in some.sort_values("level").itertuples()
        ]
        rows.append([PREDICTORS[predictor], *cells, f"{some['crps_mm'].iloc[0]:.1f}"])
    return markdown_table(["predictor", *heads, "CRPS (mm)"], rows)


def measured_forecasts(root: Path) -> str:
    """Mean position errors in mm on measured sets by cross-validation, from ``make real``."""
    query = "quantity == 'position' and bounce == 'all'"
    errors = read_report(root, "real/forecasts.csv", query).sort_values("horizon_ms", kind="stable")
    rows = []
    for (name, predictor), some in errors.groupby(["set", "predictor"], sort=False):
        cells = _with_medians(some)
        rows.append([name, ADAPTED[predictor], *cells])
    return markdown_table(["set", "predictor", *HORIZON_HEADS], rows)


def predictor_costs(root: Path) -> str:
    """Size, training time, latency and errors of predictors, from ``rallygap costs``."""
    rows = []
    for row in read_report(root, "costs/costs.csv").to_dict("records"):
        size, training = (
            f"{row[name]:,.0f}" if row[name] == row[name] else NONE
            for name in ("parameters", "training_s")
        )
        times = (f"{row[f'latency_ms_{name}']:.2f}" for name in ("median", "p99"))
        errors = (f"{row[f'position_error_mm_{horizon}ms']:.0f}" for horizon in HORIZONS_MS)
        rows.append([PREDICTORS[row["predictor"]], size, training, *times, *errors])
    head = ["predictor", "parameters", "training (s)", "one forecast, median (ms)"]
    heads = (f"error at {horizon} ms (mm)" for horizon in HORIZONS_MS)
    return markdown_table([*head, "99th percentile (ms)", *heads], rows)
