"""Evaluate the predictors: forecast error over the horizon, on every set of measured balls."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.predictors.evaluation import (
    MEASURED,
    STATISTICS,
    TRUTH,
    ForecastErrors,
    concat_tables,
)
from rallygap.models.predictors.protocol import Bools
from rallygap.models.segmentation.split import recording_groups
from rallygap.pipeline.evaluation.coverage import COLUMNS, coverage_rows
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet, read_sets, read_test_sets
from rallygap.pipeline.evaluation.example_shots import write_shots
from rallygap.pipeline.evaluation.forecasts import draw_shots, evaluate, forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, NamedPredictor, read_predictors
from rallygap.pipeline.io.ground_truth import net_contacts, read_contacts, read_truth, true_windows
from rallygap.pipeline.io.metrics import place, rounded
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.runtime.torch_threads import one_thread

Results = dict[tuple[str, str], ForecastErrors]  # by set and what it is compared with


@one_thread()
def evaluate_predictor(run: StageRun) -> None:
    """Forecast every test window with every predictor and report the errors."""
    settings, artifacts = run.params.evaluate_predictor, run.root / "artifacts"
    predictors = read_predictors(artifacts, settings)
    truth = read_truth(run.input("ingest", "truth.json"))
    every = settings.window_every_ms / 1000
    sets = read_test_sets(artifacts, every)
    validation = {measured.name: measured for measured in read_sets(artifacts, every, "validation")}
    results: Results = {}
    met_net, coverage = {}, {}
    for test in sets:
        run.log_input(test.name, run.input("segment", "samples.parquet"), len(test.windows))
        able = [predictor for predictor in predictors if predictor.forecasts(test.name)]
        forecasts = forecast_windows(test, able)
        results[test.name, MEASURED] = evaluate(forecasts, test.windows, test, settings, run.seed)
        if test.name == ARENA and truth is not None:
            contacts = read_contacts(run.input("ingest", "true_contacts.parquet"), test.recordings)
            true = true_windows(test.windows, test.recordings, truth, contacts)
            results[test.name, TRUTH] = evaluate(forecasts, true, test, settings, run.seed)
            met_net[test.name] = net_contacts(test.windows, test.recordings, contacts)
        if test.name in validation:
            coverage[test.name,] = coverage_rows(
                test, validation[test.name], able, settings.bootstrap_resamples, run.seed
            )
    tables = {key: result.over_horizon() for key, result in results.items()}
    errors = concat_tables(tables, ["set", "against"])
    run.write_metrics(
        _metrics(errors, [predictor.name for predictor in predictors if predictor.trained_on])
    )
    run.keep(
        errors=errors,
        differences=_differences(results, predictors),
        groups=_groups(sets, results),
        net=_net(met_net, results),
        predictors=_described(predictors),
        coverage=concat_tables(coverage, ["set"])
        if coverage
        else pd.DataFrame(columns=["set", "predictor", "level", *COLUMNS]),
    )
    write_shots(run.artifact("shots.json"), draw_shots(sets, predictors, run.seed))


def _metrics(errors: pd.DataFrame, trained: Sequence[str]) -> dict[str, Any]:
    """Return ``{set: {predictor: mean position error (mm), 300 ms ahead}}`` over all windows.

    Predictors without parameters from data are in the tables only.
    """
    last = errors["horizon_ms"] == errors["horizon_ms"].max()
    chosen = last & (errors["bounce"] == "all") & (errors["quantity"] == "position")
    chosen &= errors["predictor"].isin(trained)
    metrics: dict[str, Any] = {}
    for row in errors[chosen & (errors["against"] == MEASURED)].to_dict("records"):
        place(metrics, [row["set"]])[row["predictor"]] = rounded(row["mean"])
    return metrics


def _differences(results: Results, predictors: Sequence[NamedPredictor]) -> pd.DataFrame:
    """Return the paired differences between trained or amended predictors and all others."""
    differences = {
        (name,): result.differences(
            [
                predictor.name
                for predictor in predictors
                if predictor.trained_on and predictor.forecasts(name)
            ]
        )
        for (name, against), result in results.items()
        if against == MEASURED
    }
    return concat_tables(differences, ["set"])


def _groups(sets: Sequence[MeasuredSet], results: Results) -> pd.DataFrame:
    """Return the position error at 300 ms by group of recordings."""
    tables = {}
    for test in sets:
        groups = recording_groups(pd.Series(test.recordings)).replace("", "all")
        tables[(test.name,)] = results[test.name, MEASURED].by_group(groups.to_numpy())
    return concat_tables(tables, ["set"])


def _net(net_contacts: Mapping[str, Bools], results: Results) -> pd.DataFrame:
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
    return table.rename(columns={"group": "net"})


def _described(predictors: Sequence[NamedPredictor]) -> pd.DataFrame:
    """Return one row a predictor: its kind, simulator, size and training data."""
    rows = [
        {
            "predictor": predictor.name,
            "kind": predictor.kind,
            "simulator": predictor.simulator,
            "parameters": predictor.parameters,
            "starts from": predictor.starts_from,
            "trained on": ", ".join(predictor.trained_on) or None,
        }
        for predictor in predictors
    ]
    return pd.DataFrame(rows).astype({"parameters": "Int64"})


if __name__ == "__main__":
    run_stage(evaluate_predictor)
