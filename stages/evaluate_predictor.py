"""Evaluate the predictors: forecast error over the horizon, on every set of measured balls."""

from rallygap.pipeline.evaluation.coverage import coverage_figures, coverage_rows, coverage_table
from rallygap.pipeline.evaluation.evaluation_windows import read_sets, read_test_sets
from rallygap.pipeline.evaluation.example_shots import write_shots
from rallygap.pipeline.evaluation.forecasts import draw_shots, evaluate, forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, read_predictors
from rallygap.pipeline.evaluation.report import (
    MEASURED,
    TRUTH,
    difference_table,
    error_figures,
    error_table,
    group_table,
    horizon_errors,
    metrics,
    net_table,
    predictor_table,
)
from rallygap.pipeline.io.ground_truth import net_contacts, read_contacts, read_truth, true_windows
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.runtime.torch_threads import one_thread


@one_thread()
def evaluate_predictor(run: StageRun) -> None:
    """Forecast every test window with every predictor and report the errors."""
    settings, artifacts = run.params.evaluate_predictor, run.root / "artifacts"
    predictors = read_predictors(artifacts, settings)
    truth = read_truth(run.input("ingest", "truth.json"))
    every = settings.window_every_ms / 1000
    sets = read_test_sets(artifacts, every)
    validation = {one.name: one for one in read_sets(artifacts, every, "validation")}
    results, met_net, coverage = {}, {}, {}
    for one in sets:
        run.log_input(one.name, run.input("segment", "samples.parquet"), len(one.windows))
        able = [each for each in predictors if each.forecasts(one.name)]
        forecasts = forecast_windows(one, able)
        results[one.name, MEASURED] = evaluate(forecasts, one.windows, one, settings, run.seed)
        if one.name == ARENA and truth is not None:
            contacts = read_contacts(run.input("ingest", "true_contacts.parquet"), one.recordings)
            true = true_windows(one.windows, one.recordings, truth, contacts)
            results[one.name, TRUTH] = evaluate(forecasts, true, one, settings, run.seed)
            met_net[one.name] = net_contacts(one.windows, one.recordings, contacts)
        if one.name in validation:
            coverage[one.name] = coverage_rows(
                one, validation[one.name], able, settings.bootstrap_resamples, run.seed
            )
    errors = horizon_errors(results)
    run.write_metrics(metrics(errors))
    for one in sets:
        run.add(*error_figures(one, errors))
    run.add(
        error_table(errors),
        difference_table(results, predictors),
        group_table(sets, results),
        net_table(met_net, results),
        predictor_table(predictors),
        coverage_table(coverage),
        *coverage_figures(coverage),
    )
    write_shots(run.artifact("shots.json"), draw_shots(sets, predictors, run.seed))


if __name__ == "__main__":
    run_stage(evaluate_predictor)
