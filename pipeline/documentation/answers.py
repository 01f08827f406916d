"""The questions of the project, each answered in a paragraph from committed tables."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.documentation.cells import read_report
from rallygap.pipeline.documentation.gap_tables import SETS, changes
from rallygap.pipeline.documentation.predictor_tables import errors_over_windows
from rallygap.pipeline.documentation.transfer_tables import points
from rallygap.pipeline.experiments.arenas.scores import gap_closed, ratios
from rallygap.pipeline.report.real_forecasts import ADAPTED

C, C_WITH_NET, AMENDED = "physics_c", "physics_c_with_net", "amended_imperfect_c"
NETWORK, HYBRID = "transformer", "hybrid"


def when_the_swap_helps(root: Path) -> str:
    """By how much swapping physics for a learned predictor changes returns, and when."""
    query = "outcome == 'returns'"
    gains = read_report(root, "swap_study/gains.csv", query)
    gains = gains.set_index(["protocol", "predictor"]).sort_index()
    first, every = gains.loc["first_window"], gains.loc["every_tick"]
    again = read_report(root, "swap_study/gains_every_tick.csv", query).set_index("predictor")
    return (
        "With one forecast from the first window, the transformer in place of simulator C changes "
        f"returns by {points(first.loc[[NETWORK]])}, the amended simulator by "
        f"{points(first.loc[['amended']])}. With a forecast at every control step, the "
        f"transformer changes them by {points(every.loc[[NETWORK]])}, the arena's own physics by "
        f"{points(every.loc[['oracle']])}. Forecasts at every control step instead of one change "
        f"the returns with simulator C by {points(again.loc[[C]])}."
    )


def when_a_learned_predictor_helps(root: Path) -> str:
    """From how many recordings on networks err less than simulators, and on which measured sets."""
    errors = errors_over_windows(root).query("horizon_ms == 300 and set == 'arena'")
    errors = errors.set_index("predictor")["mean"]
    net = errors[C_WITH_NET]
    curves = read_report(root, "learning_curves.csv", "horizon_ms == 300")
    means = curves.pivot(index="recordings", columns="predictor", values="mean")
    return (
        f"On the arena, the mean position error 300 ms ahead is {errors[C]:.0f} mm with simulator "
        f"C and {net:.0f} mm with simulator C and a net. The latter is larger than the mean error "
        f"of a transformer with {_sizes(means[NETWORK] < net)} training recordings, and than that "
        "of a hybrid, a network that corrects its forecasts, with "
        f"{_sizes(means[HYBRID] < net)}. Simulator C amended from the same "
        "recordings has a smaller mean error than the transformer with "
        f"{_sizes(means[AMENDED] < means[NETWORK])} of them, and than the hybrid with "
        f"{_sizes(means[AMENDED] < means[HYBRID])} of them. {_on_arenas(root)} On measured sets, "
        "whose physics nobody knows, the smallest mean errors 200 ms ahead are "
        f"{_least_errors(root)}."
    )


def what_naming_buys(root: Path) -> str:
    """How much error and how many returns naming and amending are worth."""
    errors = read_report(root, "arenas/errors.csv")
    closed = 100 * gap_closed(errors, 300).median()
    of_oracle = ratios(errors, "amended", 300).median()
    verdicts = read_report(root, "real/close_gap/verdicts.csv")
    verdicts = verdicts[verdicts["source"].isin(SETS)]
    retrained = read_report(root, "swap_study/gains_retrained.csv", "outcome == 'returns'")
    falls, rises = changes(verdicts)
    return (
        f"On {errors['seed'].nunique()} fresh arenas, the median error of the amended simulator "
        f"300 ms ahead is {of_oracle:.2f} times that of the arena's own physics, and amending "
        f"closes {closed:.0f} % of the difference between simulator C and the latter (more than "
        "100 % is possible: the amended simulator corrects the error of the cameras, too). On "
        "measured sets the 95 % interval of the fall of the held-out error is above zero in "
        f"{falls} and below zero in {rises} of {len(verdicts)} verdicts. "
        "Training policies in the amended simulator instead of simulator C changes returns by "
        f"{points(retrained)}."
    )


def _sizes(chosen: Any) -> str:
    """Return for which sizes something holds: ``any number``, ``300 to 3,710``, ``10 or 30``."""
    if chosen.all():
        return "any number"
    first, last = chosen.idxmax(), chosen.index[-1]
    if first < last and chosen.loc[first:].all():
        return f"{first:,} to {last:,}"
    return " or ".join(f"{size:,}" for size in chosen.index[chosen]) or "no number"


def _on_arenas(root: Path) -> str:
    errors = read_report(root, "arenas/errors.csv")
    with_net, network, hybrid, amended = (
        f"{ratios(errors, name, 300).median():.2f}"
        for name in ("imperfect_c_with_net", NETWORK, HYBRID, "amended")
    )
    return (
        f"On {errors['seed'].nunique()} fresh arenas, the median error 300 ms ahead is {with_net} "
        "times that of the arena's own physics with simulator C and a net, "
        f"{network} with a transformer, {hybrid} with a hybrid and {amended} with simulator C "
        "amended."
    )


def _least_errors(root: Path) -> str:
    query = "quantity == 'position' and bounce == 'all' and horizon_ms == 200"
    errors = read_report(root, "real/forecasts.csv", query)
    found = []
    for name, some in errors.groupby("set", sort=False):
        best = some.loc[some["mean"].idxmin()]
        found.append(f"{best['mean']:.0f} mm ({ADAPTED[best['predictor']]}, `{name}`)")
    return ", ".join(found)
