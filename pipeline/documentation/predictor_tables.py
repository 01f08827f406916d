"""Tables of forecast errors and of what predictors cost."""

from pathlib import Path
from typing import Any

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.documentation.cells import (
    HORIZON_HEADS,
    NONE,
    predictor_name,
    read_report,
    with_interval,
)
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.report.real_forecasts import ADAPTED

SHORT = 300  # recordings
SMALLER, PAPER_NETWORK = "transformer", "paper_network"  # of the same shots
# As many networks each.
HYBRID_PAIRS = {("hybrid", "transformer"), ("hybrid_ensemble", "transformer_ensemble")}
COVERAGE_HEADS = (
    *(f"{level} % region: coverage (%), radius (mm)" for level in (50, 90)),
    "CRPS (mm)",
)


def errors_over_windows(root: Path, run: str = "") -> Any:
    """Return the position errors against measured states, over all windows of each set.

    Args:
        root: of the repository.
        run: a kept run, such as ``paper/``; the present reports where empty.
    """
    query = "against == 'measured' and quantity == 'position' and bounce == 'all'"
    return read_report(root, f"{run}evaluate_predictor/forecast_error.csv", query)


def position_errors(root: Path, run: str = "", *, arena: bool) -> str:
    """Mean position errors in mm with 95 % intervals, from ``evaluate_predictor``.

    Args:
        root: of the repository.
        run: a kept run, such as ``paper/``; the present reports where empty.
        arena: whether the rows are those of the arena, or of the measured sets.
    """
    errors = errors_over_windows(root, run)
    errors = errors[(errors["set"] == "arena") == arena].sort_values("horizon_ms", kind="stable")
    rows = []
    for (name, predictor), some in errors.groupby(["set", "predictor"], sort=False):
        cells = [with_interval(row.mean, row.ci_low, row.ci_high) for row in some.itertuples()]
        rows.append([name, predictor_name(predictor), *cells])
    return markdown_table(["set", "predictor", *HORIZON_HEADS], rows)


def paper_network(root: Path) -> str:
    """Mean position errors in mm of the paper's network and of the smaller one, and differences.

    From ``make paper-network``; both are transformers that have learned from the same shots.
    """
    query = f"predictor in ('{SMALLER}', '{PAPER_NETWORK}') and quantity == 'position'"
    errors = read_report(root, "paper_network.csv", f"{query} and bounce == 'all'")
    query = f"other == '{SMALLER}' and quantity == 'position'"
    differences = read_report(root, "paper_network_differences.csv", query)
    parts = {
        "transformer": errors[errors["predictor"] == SMALLER],
        "transformer of the paper's size": errors[errors["predictor"] == PAPER_NETWORK],
        "difference": differences,
    }
    rows = []
    for name, some in parts.items():
        found = some.sort_values("horizon_ms").itertuples()
        cells = [with_interval(row.mean, row.ci_low, row.ci_high, ".1f") for row in found]
        rows.append([name, *cells])
    return markdown_table(["predictor", *HORIZON_HEADS], rows)


def paper_network_training(root: Path) -> str:
    """How the paper's network was trained, in a sentence."""
    record = read_json(root / "reports" / "paper_network.json")
    epochs = len(read_report(root, "paper_network_training.csv"))
    return (
        f"{record['parameters'] / 1e6:.1f} million parameters, {epochs} epochs of "
        f"{record['training_episodes']:,} episodes, {record['training_s'] / 60:.0f} minutes on one "
        f"{record['gpu']}"
    )


def paper_network_short(root: Path) -> str:
    """The mean position errors of both networks 300 ms ahead, in half a sentence."""
    query = "quantity == 'position' and bounce == 'all' and horizon_ms == 300"
    errors = read_report(root, "paper_network.csv", query).set_index("predictor")["mean"]
    return (
        f"its mean position error 300 ms ahead is {errors[PAPER_NETWORK]:.0f} mm, that of the "
        f"smaller transformer {errors[SMALLER]:.0f} mm"
    )


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
        rows.append([predictor_name(predictor), *cells])
    return markdown_table(["predictor", *errors[column].unique()], rows)


def _with_medians(rows: Any) -> list[str]:
    """Return the mean of each row with its interval and its median."""
    return [
        f"{with_interval(row.mean, row.ci_low, row.ci_high)}, median {row.median:.0f}"
        for row in rows.itertuples()
    ]


def learning_curves(root: Path) -> str:
    """Mean position errors in mm at 300 ms by number of recordings, from ``make learning-curves``.

    The last column is the error with all recordings, divided by that of the oracle.
    """
    curves = read_report(root, "learning_curves.csv", "horizon_ms == 300")
    rows = []
    for predictor, some in curves.groupby("predictor", sort=False):
        some = some.sort_values("recordings")
        cells = [with_interval(row.mean, row.ci_low, row.ci_high) for row in some.itertuples()]
        rows.append([predictor_name(predictor), *cells, f"{some['of_oracle'].iloc[-1]:.2f}"])
    sizes = [f"{size:,} recordings" for size in sorted(curves["recordings"].unique())]
    return markdown_table(["predictor", *sizes, "error with all / oracle's"], rows)


def learning_curves_short(root: Path) -> str:
    """What the learning curves say 300 ms ahead, in a sentence."""
    curves = read_report(root, "learning_curves.csv", "horizon_ms == 300")
    errors = curves.set_index(["predictor", "recordings"])["mean"]
    most = curves["recordings"].max()
    few = errors["amended_imperfect_c", SHORT]
    network, oracle = (errors[name, most] for name in ("transformer", "oracle"))
    return (
        "On the arena, a simulated environment with hidden physics, position errors 300 ms ahead "
        f"are {few:.0f} mm with simulator C amended from {SHORT} recordings, {network:.0f} mm with "
        f"a transformer trained on {most:,}, and {oracle:.0f} mm with the arena's own physics "
        "([method and all numbers](docs/results.md#how-many-recordings-predictors-need))."
    )


def coverage(root: Path) -> str:
    """Coverage and size of prediction regions at 300 ms on the arena, and the score."""
    query = "set == 'arena' and horizon_ms == 300"
    table = read_report(root, "evaluate_predictor/coverage.csv", query)
    rows = [
        [predictor_name(predictor), *_covered(some)]
        for predictor, some in table.groupby("predictor", sort=False)
    ]
    return markdown_table(["predictor", *COVERAGE_HEADS], rows)


def measured_coverage(root: Path) -> str:
    """Coverage and size of prediction regions at 200 ms on measured sets, from ``make real``."""
    table = read_report(root, "real/forecast_coverage.csv", "horizon_ms == 200")
    rows = [
        [name, ADAPTED[predictor], *_covered(some)]
        for (name, predictor), some in table.groupby(["set", "predictor"], sort=False)
    ]
    return markdown_table(["set", "predictor", *COVERAGE_HEADS], rows)


def _covered(rows: Any) -> list[str]:
    """Return coverage and size of regions by their level, and the score."""
    cells = []
    for row in rows.sort_values("level").to_dict("records"):
        share, low, high = (100 * row[name] for name in ("coverage", "ci_low", "ci_high"))
        cells.append(f"{with_interval(share, low, high, '.1f')}, {row['size_mm']:.0f}")
    return [*cells, f"{rows['crps_mm'].iloc[0]:.1f}"]


def measured_forecasts(root: Path) -> str:
    """Mean position errors in mm on measured sets by cross-validation, from ``make real``."""
    query = "quantity == 'position' and bounce == 'all'"
    errors = read_report(root, "real/forecasts.csv", query).sort_values("horizon_ms", kind="stable")
    rows = []
    for (name, predictor), some in errors.groupby(["set", "predictor"], sort=False):
        cells = _with_medians(some)
        rows.append([name, ADAPTED[predictor], *cells])
    return markdown_table(["set", "predictor", *HORIZON_HEADS], rows)


def measured_differences(root: Path) -> str:
    """By how much hybrids err more than other learned predictors, mm, window by window.

    On measured sets by cross-validation, from ``make real``.
    """
    pairs = read_report(root, "real/forecast_differences.csv", "quantity == 'position'")
    rows = []
    for keys, some in pairs.groupby(["set", "predictor", "other"], sort=False):
        if keys[1:] not in HYBRID_PAIRS:
            continue
        found = some.sort_values("horizon_ms").itertuples()
        cells = [with_interval(row.mean, row.ci_low, row.ci_high, ".1f") for row in found]
        rows.append([keys[0], *(ADAPTED[one] for one in keys[1:]), *cells])
    return markdown_table(["set", "predictor", "minus", *HORIZON_HEADS], rows)


def predictor_costs(root: Path) -> str:
    """Size, training time and latency of predictors, from ``rallygap costs``, and their errors."""
    errors = errors_over_windows(root).query("set == 'arena'")
    means = errors.set_index(["predictor", "horizon_ms"])["mean"]
    rows = []
    for row in read_report(root, "costs/costs.csv").to_dict("records"):
        size, training = (
            f"{row[name]:,.0f}" if row[name] == row[name] else NONE
            for name in ("parameters", "training_s")
        )
        times = (f"{row[f'latency_ms_{name}']:.2f}" for name in ("median", "p99"))
        name = row["predictor"]
        shown = (f"{means[name, horizon]:.0f}" for horizon in SHOWN_HORIZONS_MS)
        rows.append([predictor_name(name), size, training, *times, *shown])
    head = ["predictor", "parameters", "training (s)", "one forecast, median (ms)"]
    heads = (f"error at {horizon} ms (mm)" for horizon in SHOWN_HORIZONS_MS)
    return markdown_table([*head, "99th percentile (ms)", *heads], rows)
