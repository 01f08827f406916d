"""The results that the report page opens with: a sentence with its numbers, and a figure, each."""

from collections.abc import Callable, Iterator, Set

from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.web.labels import simulator_label
from rallygap.pipeline.web.pages import read_figure

LAST_MS = 300  # the farthest horizon
NEARER_MS = "115-125"  # horizons of the policies
COMPARED = ("physics_c", "transformer", "amended")  # predictors
FEW = 300  # recordings


def _gap(run: Reports) -> str:
    keys, numbers = ["source", "simulator", "horizon_ms"], ["before_mm", "after_mm", "floor_mm"]
    table = run.table("close_gap/errors.csv", keys, numbers)
    row = table[(table["source"] == "arena") & (table["horizon_ms"] == LAST_MS)].iloc[0]
    simulator = simulator_label(row["simulator"])
    return (
        f"The prediction error of {simulator} on held-out shots of the arena, "
        f"{LAST_MS} ms ahead, is {row['before_mm']:.0f} mm before and {row['after_mm']:.0f} mm "
        "after it is amended by the effects that are named. The prediction floor is "
        f"{row['floor_mm']:.0f} mm."
    )


def _exam(run: Reports) -> str:
    rates = run.table("exam/rates.csv", ["rate"], ["rallygap"]).set_index("rate")["rallygap"]
    return (
        f"In blind tests, {rates['distinguishable_right']:.0f} of {rates['distinguishable']:.0f} "
        "distinguishable hidden effects of three detection limits are named, and "
        f"{rates['pairs_right']:.0f} of {rates['pairs']:.0f} pairs. False alarms on sets without a "
        f"hidden effect: {rates['false_alarms']:.0f} of {rates['clean_sets']:.0f}."
    )


def _real(run: Reports) -> str:
    keys = ["set", "predictor", "quantity", "bounce", "horizon_ms"]
    table = run.table("real_forecasts/errors.csv", keys, ["mean"])
    kept = (table["quantity"] == "position") & (table["bounce"] == "all")
    rows = table[kept & (table["horizon_ms"] == LAST_MS)].set_index(["set", "predictor"])["mean"]
    errors = "; ".join(
        f"{name} {rows[name, 'physics_literature']:.0f} to {rows[name, 'hybrid_ensemble']:.0f} mm"
        for name in rows.index.unique(0)
    )
    return (
        f"Errors on measured sets, {LAST_MS} ms ahead, from the literature's simulator to a hybrid "
        f"and a transformer together, by cross-validation: {errors}."
    )


def _predictor(run: Reports) -> str:
    table = run.table(
        "learning_curves/errors.csv", ["predictor", "recordings", "horizon_ms"], ["mean"]
    )
    errors = table[table["horizon_ms"] == LAST_MS].set_index(["predictor", "recordings"])["mean"]
    most = table["recordings"].max()
    return (
        f"{LAST_MS} ms ahead, simulator C amended by {FEW} recordings errs "
        f"{errors['amended_imperfect_c', FEW]:.0f} mm, a transformer trained on {most:,} "
        f"{errors['transformer', most]:.0f} mm, and the arena's own physics "
        f"{errors['oracle', most]:.0f} mm."
    )


def _swap(run: Reports) -> str:
    keys = ["observation", "horizons_ms", "predictor", "protocol"]
    rate = ["return_rate", "return_rate_low", "return_rate_high"]
    table = run.table("swap_study/readings_all.csv", keys, rate)
    chosen = (table["observation"] == "intercept") & (table["horizons_ms"] == NEARER_MS)
    table = table[chosen & table["predictor"].isin(COMPARED)]
    rates = 100 * table.set_index(["protocol", "predictor"])[rate]
    first, every = (
        "{:.0f}, {:.0f} and {:.0f} %".format(
            *(rates["return_rate"][protocol, predictor] for predictor in COMPARED)
        )
        for protocol in ("first_window", "every_tick")
    )
    half = (rates["return_rate_high"] - rates["return_rate_low"]).max() / 2
    return (
        f"Policies return {first} of replayed shots with one forecast from the first window by "
        f"simulator C, a transformer and the amended simulator, and {every} with a forecast at "
        f"every control step (95 % intervals: at most ± {half:.0f} points)."
    )


# Heading, sentence from the reports, and figure in their folder, by place in the page. A sentence
# that lacks a number, as with other parameters, raises LookupError.
RESULTS: dict[str, tuple[str, Callable[[Reports], str], str]] = {
    "gap": ("The gap", _gap, "close_gap/figures/errors_arena.png"),
    "exam": ("The exam", _exam, "exam/figures/accuracy.png"),
    "real": ("Measured recordings", _real, "real_forecasts/figures/errors.png"),
    "predictor": ("Predictors", _predictor, "learning_curves/figures/errors.png"),
    "swap": ("The predictor swap", _swap, "swap_study/figures/readings.png"),
}


def results_section(run: Reports, anchors: Set[str]) -> Iterator[dict[str, str]]:
    """Yield what the template shows of each result that a run has the figure and numbers for.

    Args:
        run: the reports.
        anchors: of the figures on the page.
    """
    for key, (heading, sentence, figure) in RESULTS.items():
        try:
            text = sentence(run)
        except LookupError:
            continue
        if figure in anchors:
            yield {
                "key": key,
                "heading": heading,
                "sentence": text,
                "source": read_figure(run.folder / figure),
                "stage": figure.split("/")[0],
                "anchor": figure,
            }
