"""Claims of the paper's Figure 3: whose forecast errors are smaller, at every horizon."""

from collections.abc import Collection

from pipeline.paper.run_reports import Reports
from pipeline.paper.verdicts import FAILS, HOLDS, OPEN, Interval, claim, combined

ERRORS = "evaluate_predictor/forecast_error.csv"
DIFFERENCES = "evaluate_predictor/forecast_error_difference.csv"
SET, LEARNED = "arena", "transformer"
HORIZONS_MS = (100, 200, 300)  # those that the tables of a run have


def smaller_error(run: Reports, rival: str, quantity: str) -> tuple[str, Interval] | None:
    """Return whether the transformer's mean error is below a rival's at every horizon.

    Returns:
        The verdict, and the difference at the last horizon in percent of the rival's error;
        ``None`` where the reports do not have them.
    """
    found = [_difference(run, rival, quantity, horizon) for horizon in HORIZONS_MS]
    last = run.number(
        ERRORS, "mean", set=SET, against="measured", predictor=rival, quantity=quantity,
        bounce="all", horizon_ms=HORIZONS_MS[-1],
    )  # fmt: skip
    known = [one for one in found if one is not None]
    if len(known) < len(found) or last is None:
        return None
    word = combined(claim(interval, grows=False) for interval, _ in known)
    if word == HOLDS and min(lower for _, lower in known) < 1:
        word = OPEN
    return word, known[-1][0].times(100 / last)


def _difference(
    run: Reports, rival: str, quantity: str, horizon: int
) -> tuple[Interval, float] | None:
    """Return the transformer's error minus a rival's, and at which share of horizons it is less.

    The table has a pair of predictors in either order.
    """
    at: dict[str, str | int] = {"set": SET, "quantity": quantity, "horizon_ms": horizon}
    for first, second, sign in ((LEARNED, rival, 1), (rival, LEARNED, -1)):
        found = run.numbers(
            DIFFERENCES, ["mean", "ci_low", "ci_high", "lower_share"],
            predictor=first, other=second, **at,
        )  # fmt: skip
        if found is not None:
            *interval, lower = found
            return Interval(*interval).times(sign), lower if sign > 0 else 1 - lower
    return None


def smallest_spread(
    run: Reports, quantity: str, rivals: Collection[str]
) -> tuple[str, float] | None:
    """Return whether the transformer's errors have the smallest standard deviation.

    Returns:
        The verdict, and its excess over the smallest of the rivals at the last horizon (percent);
        ``None`` where the reports do not have them.
    """
    keys = ["set", "against", "quantity", "bounce", "horizon_ms", "predictor"]
    table = run.table(ERRORS, keys, ["std"])
    if not {LEARNED, *rivals} <= set(table.get("predictor", ())):
        return None
    chosen = table[
        (table["set"] == SET)
        & (table["against"] == "measured")
        & (table["quantity"] == quantity)
        & (table["bounce"] == "all")
    ]
    spread = chosen.pivot(index="horizon_ms", columns="predictor", values="std")
    best = spread[[*rivals]].min(axis=1)
    word = HOLDS if (spread[LEARNED] < best).all() else FAILS
    return word, 100 * float((spread[LEARNED] / best).iloc[-1] - 1)
