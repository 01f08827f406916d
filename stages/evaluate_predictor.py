"""Evaluate the predictors: forecast error over the horizon, on every set of measured balls."""

from models.arena.truth import Truth
from models.predictors.windows import Windows
from pipeline.evaluation.example_shots import write_shots
from pipeline.evaluation.forecasts import draw_shots, evaluate, forecast_windows
from pipeline.evaluation.predictors import ARENA, read_predictors
from pipeline.evaluation.report import (
    MEASURED,
    TRUTH,
    difference_table,
    error_figures,
    error_table,
    group_table,
    horizon_errors,
    metrics,
    predictor_table,
)
from pipeline.evaluation.test_windows import MeasuredSet, read_test_sets
from pipeline.io.ground_truth import read_truth, true_windows
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.runtime.torch_threads import one_thread


@one_thread()
def evaluate_predictor(run: StageRun) -> None:
    """Forecast every test window with every predictor and report the errors."""
    settings, artifacts = run.params.evaluate_predictor, run.root / "artifacts"
    predictors = read_predictors(artifacts, settings)
    truth = read_truth(run.input("ingest", "truth.json"))
    sets = read_test_sets(artifacts, settings.window_every_ms / 1000)
    results = {}
    for one in sets:
        run.log_input(one.name, run.input("segment", "samples.parquet"), len(one.windows))
        forecasts = forecast_windows(one, [each for each in predictors if each.forecasts(one.name)])
        for against, windows in _references(run, one, truth).items():
            results[one.name, against] = evaluate(forecasts, windows, one, settings, run.seed)
    errors = horizon_errors(results)
    run.write_metrics(metrics(errors))
    for one in sets:
        run.add(*error_figures(one, errors))
    run.add(
        error_table(errors),
        difference_table(results, predictors),
        group_table(sets, results),
        predictor_table(predictors),
    )
    write_shots(run.artifact("shots.json"), draw_shots(sets, predictors, run.seed))


def _references(run: StageRun, one: MeasuredSet, truth: Truth | None) -> dict[str, Windows]:
    """Return the set's windows with the measured and, on the arena, the true future."""
    references = {MEASURED: one.windows}
    if one.name == ARENA and truth is not None:
        path = run.input("ingest", "true_contacts.parquet")
        references[TRUTH] = true_windows(one.windows, one.recordings, truth, path)
    return references


if __name__ == "__main__":
    run_stage(evaluate_predictor)
