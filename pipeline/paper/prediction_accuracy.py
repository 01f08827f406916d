"""How far forecasts are off: the paper's figure of prediction accuracy, claim by claim."""

from functools import partial

from pipeline.paper.entries import MISSING, NOTHING, Entry, Finding, Group
from pipeline.paper.judgements import FAILS, HOLDS, OPEN, Interval, claim, of_all
from pipeline.paper.run_reports import Reports

ERRORS = "evaluate_predictor/forecast_error.csv"
DIFFERENCES = "evaluate_predictor/forecast_error_difference.csv"
SET, LEARNED = "arena", "transformer"
RIVALS = {
    "physics_c": "physics with simulator C",
    "physics_literature": "physics with the literature's constants",
    "tae": "TAE",
    "gru_tae": "GRU-TAE",
}
OTHERS = {
    "amended_imperfect_c": "physics with simulator C, amended by training balls",
    "oracle": "the oracle, which knows the hidden physics",
}
QUANTITIES = ("position", "velocity", "spin")
HORIZONS_MS = (100, 200, 300)


def difference(
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


def lowest(rival: str, quantity: str, run: Reports) -> Finding:
    """Return whether the transformer's mean error is below a rival's at every horizon."""
    found = [difference(run, rival, quantity, horizon) for horizon in HORIZONS_MS]
    last = run.number(
        ERRORS, "mean", set=SET, against="measured", predictor=rival, quantity=quantity,
        bounce="all", horizon_ms=HORIZONS_MS[-1],
    )  # fmt: skip
    known = [one for one in found if one is not None]
    if len(known) < len(found) or last is None:
        return MISSING
    word = of_all(claim(interval, grows=False) for interval, _ in known)
    if word == HOLDS and min(lower for _, lower in known) < 1:
        word = OPEN
    shown = known[-1][0].times(100 / last)
    return Finding(word, shown.value, shown)


def steadiest(quantity: str, run: Reports) -> Finding:
    """Return whether the transformer's errors spread least, of all that the paper compares."""
    keys = ["set", "against", "quantity", "bounce", "horizon_ms", "predictor"]
    table = run.table(ERRORS, keys, ["std"])
    if not {LEARNED, *RIVALS} <= set(table.get("predictor", ())):
        return MISSING
    chosen = table[
        (table["set"] == SET)
        & (table["against"] == "measured")
        & (table["quantity"] == quantity)
        & (table["bounce"] == "all")
    ]
    spread = chosen.pivot(index="horizon_ms", columns="predictor", values="std")
    best = spread[list(RIVALS)].min(axis=1)
    word = HOLDS if (spread[LEARNED] < best).all() else FAILS
    return Finding(word, 100 * float((spread[LEARNED] / best).iloc[-1] - 1))


def _entry(rival: str, name: str, quantity: str, printed: str) -> Entry:
    return Entry(
        f"accuracy.{quantity}.{rival}",
        f"mean {quantity} error of the transformer below that of {name}",
        None,
        "%",
        "evaluate_predictor",
        f"{DIFFERENCES}: mean, ci_low, ci_high, lower_share",
        partial(lowest, rival, quantity),
        words=printed,
    )


def _spread(quantity: str) -> Entry:
    return Entry(
        f"accuracy.{quantity}.spread",
        f"standard deviation of the {quantity} error the smallest of all",
        None,
        "%",
        "evaluate_predictor",
        f"{ERRORS}: std",
        partial(steadiest, quantity),
        words="small",
    )


ACCURACY = Group(
    "accuracy",
    "Figure 3: forecast error from 100 to 300 ms",
    "Ours is the error of the transformer minus that of the other at 300 ms, in percent of the "
    "latter, on the arena's test recordings. The verdict asks more: a lower mean at each of the 41 "
    "horizons, and intervals below zero at 100, 200 and 300 ms. Standard deviations have no "
    "interval; they are compared at these three horizons with the smallest of the others.",
    (-100.0, 50.0),
    (
        *(_entry(*rival, quantity, "lower") for quantity in QUANTITIES for rival in RIVALS.items()),
        *map(_spread, QUANTITIES),
    ),
)

BESIDE_OTHERS = Group(
    "beside_others",
    "Beside Figure 3: the amended simulator, and the oracle",
    "The paper has no such contenders. The numbers are as above: below zero, the transformer is "
    "the better of the two. The oracle's error is about the least that can be had.",
    (-100.0, 150.0),
    tuple(_entry(*rival, quantity, NOTHING) for quantity in QUANTITIES for rival in OTHERS.items()),
)
