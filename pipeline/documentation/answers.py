"""The questions of the project, each answered in a paragraph from committed tables."""

from pathlib import Path
from typing import Any

from pipeline.arenas.scores import gap_closed, ratios
from pipeline.documentation.cells import read_report
from pipeline.documentation.gap_tables import SETS
from pipeline.documentation.transfer_tables import SIGNIFICANT
from pipeline.real_forecasts.figure import ADAPTED

C, AMENDED, NETWORK, HYBRID, ORACLE = (
    "physics_c",
    "amended_imperfect_c",
    "transformer",
    "hybrid",
    "oracle",
)


def when_the_swap_helps(root: Path) -> str:
    """By how much exchanging physics for a learned predictor changes returns, and when."""
    gains = read_report(root, "swap_study/gains.csv", "outcome == 'returns'")
    first, every, oracle = (
        gains[(gains["protocol"] == protocol) & (gains["predictor"] == predictor)]
        for protocol, predictor in (
            ("first_window", NETWORK),
            ("every_tick", NETWORK),
            ("every_tick", ORACLE),
        )
    )
    return (
        "Where physics forecasts once, from the first window, the transformer returns "
        f"{_points(first)}. Where physics forecasts again at every control step, the transformer "
        f"returns {_points(every)}, and the arena's own physics {_points(oracle)}. So the swap "
        "helps a policy whose physics keeps its first estimate of the state; with an estimate of "
        "the last 60 ms at every step, a better forecast adds little."
    )


def when_a_learned_predictor_helps(root: Path) -> str:
    """From how many recordings on networks err less than simulators, and on which measured sets."""
    query = "horizon_ms == 300 and set == 'arena' and quantity == 'position' and bounce == 'all'"
    errors = read_report(root, "evaluate_predictor/forecast_error.csv", query)
    unchanged = errors.query("against == 'measured'").set_index("predictor").loc[C, "mean"]
    curves = read_report(root, "learning_curves.csv", "horizon_ms == 300")
    means = curves.pivot(index="recordings", columns="predictor", values="mean")
    network, hybrid = ((means[name] < unchanged).idxmax() for name in (NETWORK, HYBRID))
    return (
        f"On the arena, simulator C errs {unchanged:.0f} mm 300 ms ahead. A transformer errs less "
        f"from {network:,} training recordings on, and a hybrid, a network that corrects simulator "
        f"C with a net, from {hybrid:,} on. With as many recordings, simulator C amended errs less "
        f"than the transformer with {_sizes(means[AMENDED] < means[NETWORK])} of them, and less "
        f"than the hybrid with {_sizes(means[AMENDED] < means[HYBRID])}. On measured sets, whose "
        f"physics nobody knows, the least mean errors 200 ms ahead are {_least_errors(root)}."
    )


def what_naming_buys(root: Path) -> str:
    """How much error and how many returns naming and amending are worth."""
    errors = read_report(root, "arenas/errors.csv")
    closed = 100 * gap_closed(errors, 300).median()
    of_oracle = ratios(errors, "amended", 300).median()
    verdicts = read_report(root, "real/close_gap/verdicts.csv")
    verdicts = verdicts[verdicts["source"].isin(SETS)]
    retrained = read_report(root, "swap_study/gains_retrained.csv", "outcome == 'returns'")
    falls = (verdicts["reduction_low_mm"] > 0).sum()
    return (
        f"On twenty fresh arenas, amending takes away {closed:.0f} % of the error that better "
        f"physics can remove, in median, and leaves {of_oracle:.2f} times the error of the "
        "arena's own physics. On measured sets the held-out error falls significantly in "
        f"{falls} of {len(verdicts)} verdicts. Policies that are trained again in the amended "
        f"simulator return {_points(retrained)} of the same replayed shots."
    )


def _points(gains: Any) -> str:
    """Return the range of differences, and how many of them are significant."""
    low, high = 100 * gains["difference"].min(), 100 * gains["difference"].max()
    significant = (gains["p_holm"] < SIGNIFICANT).sum()
    return (
        f"{low:+.0f} to {high:+.0f} points ({significant} of {len(gains)} differences significant)"
    )


def _sizes(chosen: Any) -> str:
    """Return the sizes for which something holds: ``300, 1,000``."""
    sizes = [f"{size:,}" for size in chosen.index[chosen]]
    return ", ".join(sizes) or "none"


def _least_errors(root: Path) -> str:
    query = "quantity == 'position' and bounce == 'all' and horizon_ms == 200"
    errors = read_report(root, "real/forecasts.csv", query)
    found = []
    for name, some in errors.groupby("set", sort=False):
        best = some.loc[some["mean"].idxmin()]
        found.append(f"{best['mean']:.0f} mm ({ADAPTED[best['predictor']]}, `{name}`)")
    return ", ".join(found)
