"""The report of evaluate_predictor: tables and figures with their captions, and metrics."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.predictors.evaluation import (
    SHOWN_HORIZONS_MS,
    STATISTICS,
    ForecastErrors,
    concat_tables,
)
from rallygap.models.predictors.protocol import Bools
from rallygap.models.segmentation.split import recording_groups
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet
from rallygap.pipeline.evaluation.figures.forecast_error import forecast_error_figure
from rallygap.pipeline.evaluation.predictors import NamedPredictor
from rallygap.pipeline.io.metrics import place, rounded
from rallygap.pipeline.io.report_items import ReportFigure, ReportTable

VARIANTS = ("_with_net", "_without_net")  # of predictors, in the tables only
MEASURED, TRUTH = "measured", "truth"  # what forecasts are compared with

Results = Mapping[tuple[str, str], ForecastErrors]  # by set and what it is compared with


def horizon_errors(results: Results) -> pd.DataFrame:
    """Return the errors over the horizon of all sets, with columns ``set`` and ``against``."""
    tables = {key: result.over_horizon() for key, result in results.items()}
    return concat_tables(tables, ["set", "against"])


def metrics(errors: pd.DataFrame) -> dict[str, Any]:
    """Return ``{set: {predictor: {quantity: {horizon_ms: {mean, std, n}}}}}`` over all windows."""
    result: dict[str, Any] = {}
    for row in errors[errors["bounce"] == "all"].to_dict("records"):
        label = _label(row["set"], row["against"])
        keys = (label, row["predictor"], row["quantity"], row["horizon_ms"])
        values = {"mean": rounded(row["mean"]), "std": rounded(row["std"]), "n": row["n"]}
        place(result, keys).update(values)
    return result


def error_figures(measured: MeasuredSet, errors: pd.DataFrame) -> Iterator[ReportFigure]:
    """Yield the figures of a set: the error over the horizon, against measurement and truth."""
    for against, rows in errors[errors["set"] == measured.name].groupby("against", sort=False):
        label = _label(measured.name, str(against))
        state = "measured" if against == MEASURED else "true"
        drawn = rows[~rows["predictor"].str.endswith(VARIANTS)]
        yield ReportFigure(
            forecast_error_figure(drawn.assign(set=label)),
            f"forecast_error_{label}",
            title=f"Forecast error on {measured.name}, against the {state} state",
            caption=_caption(measured, state),
        )


def error_table(errors: pd.DataFrame) -> ReportTable:
    """Return the errors at three horizons."""
    return ReportTable(
        errors[errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)],
        "forecast_error",
        title="Forecast error at 100, 200 and 300 ms",
        caption="Mean with its 95 % interval bootstrapped over recordings, median and standard "
        "deviation over windows. Position in mm, velocity in m/s, spin in rad/s; n windows. "
        "Simulated balls also against the true state, on the same windows.",
    )


def difference_table(results: Results, predictors: Sequence[NamedPredictor]) -> ReportTable:
    """Return the paired differences between trained or amended predictors and all others."""
    differences = {
        (name,): result.differences(
            [one.name for one in predictors if one.trained_on and one.forecasts(name)]
        )
        for (name, against), result in results.items()
        if against == MEASURED
    }
    return ReportTable(
        concat_tables(differences, ["set"]),
        "forecast_error_difference",
        title="Predictors with training data compared with the others",
        caption="Error of the predictor minus that of the other on the same windows, with its 95 % "
        "interval bootstrapped over recordings: negative where the predictor is better. "
        "lower_share: share of all horizons from 100 to 300 ms at which its mean error is "
        "lower. Position in mm, velocity in m/s, spin in rad/s; n windows.",
    )


def group_table(sets: Sequence[MeasuredSet], results: Results) -> ReportTable:
    """Return the position error at 300 ms by group of recordings."""
    tables = {}
    for one in sets:
        groups = recording_groups(pd.Series(one.recordings)).replace("", "all")
        tables[(one.name,)] = results[one.name, MEASURED].by_group(groups.to_numpy())
    return ReportTable(
        concat_tables(tables, ["set"]),
        "forecast_error_by_group",
        title="Position error at 300 ms, by group of recordings",
        caption="Mean in mm with its 95 % interval bootstrapped over recordings; n windows.",
    )


def net_table(net_contacts: Mapping[str, Bools], results: Results) -> ReportTable:
    """Return the position error at 300 ms of windows with and without net contact.

    Args:
        net_contacts: (B,) whether the ball meets the net within each window, by set.
        results: of all sets.
    """
    tables = {
        (name,): results[name, MEASURED].by_group(np.where(met, "with", "without"))
        for name, met in net_contacts.items()
    }
    none = pd.DataFrame(columns=["set", "group", "predictor", *STATISTICS])
    table = concat_tables(tables, ["set"]) if tables else none
    return ReportTable(
        table.rename(columns={"group": "net"}),
        "forecast_error_by_net",
        title="Position error at 300 ms, with and without net contact",
        caption="Mean in mm with its 95 % interval bootstrapped over recordings; n windows. with: "
        "the ball truly meets the net within the 300 ms, which is known for the arena only.",
    )


def predictor_table(predictors: Sequence[NamedPredictor]) -> ReportTable:
    """Return the list of the predictors."""
    rows = [
        {
            "predictor": one.name,
            "kind": one.kind,
            "simulator": one.simulator,
            "parameters": one.parameters,
            "starts from": one.starts_from,
            "trained on": ", ".join(one.trained_on) or None,
        }
        for one in predictors
    ]
    return ReportTable(
        pd.DataFrame(rows).astype({"parameters": "Int64"}),
        "predictors",
        title="Predictors",
        caption="The simulator or the number of trained parameters of each predictor, and its "
        "training data. Amended simulators forecast balls of the source that amended them. The "
        "oracle knows the hidden physics of the arena, not the systematic errors of its cameras.",
    )


def _label(name: str, against: str) -> str:
    return name if against == MEASURED else f"{name}_{against}"


def _caption(measured: MeasuredSet, state: str) -> str:
    caption = (
        f"Distance between forecast and {state} state over the horizon: mean over the test windows "
        "(line) with its 95 % interval bootstrapped over recordings (band), and standard "
        "deviation. A window counts as with a bounce if the ball meets the table within 300 ms. "
        f"{measured.source.note}"
    )
    if measured.source.spin == "per_recording":
        caption += (
            " A shot has one spin label, valid until the first contact or the end of the tracked "
            "arc: the spin error contains only forecasts before a contact."
        )
    return caption
