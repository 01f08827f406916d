"""Shot quality: speed, spin, clearance and winning probability of the returns of sim2real."""

import pandas as pd

from rallygap.models.shot_quality.forest import Forest
from rallygap.models.shot_quality.shots import Shots
from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.shot_quality.professionals import read_professionals
from rallygap.pipeline.shot_quality.returns import (
    experiments,
    median_win_probabilities,
    order_agreement,
    out_of_range_table,
    quality_table,
    receiver_forests,
    return_features,
    returns_table,
    swap_table,
)
from rallygap.pipeline.shot_quality.validation import (
    Validations,
    calibration_table,
    importance_table,
    score_table,
    validate,
)
from rallygap.pipeline.transfer.returns import read_played


def shot_quality(run: StageRun) -> None:
    """Train the forest on professionals' points and evaluate all returns of sim2real."""
    settings, seed = run.params.shot_quality, run.seed
    played = read_played(run.input("sim2real", "played.parquet"))
    shots = read_professionals(run.root / "artifacts")
    run.log_input("returns of professionals", run.input("ingest", "points.parquet"), len(shots))
    validations = _validated(run, shots)
    forest = Forest(shots.features, shots.wins, settings.forest, seed)
    returns = returns_table(played, forest)
    if not len(returns):
        warn("no ball of sim2real was returned, so there are no medians; train policies for longer")
    write_table(run.artifact("returns.parquet"), returns)
    results = experiments(played, returns, settings.bootstrap_resamples, seed)
    quality = quality_table(results)

    scores = score_table(shots, validations, settings.bootstrap_resamples, seed)
    importance = importance_table(shots, validations["wins", "forest"], seed)
    calibration = calibration_table(validations)

    receivers, others = receiver_forests(settings, seed)
    point = Forest(shots.features, shots.point, settings.forest, seed)
    features = return_features(played[played["returned"]])
    forests = {"as_measured": forest, "point": point, **others}
    medians = median_win_probabilities(returns, features, forests)
    receivers["order_agreement"] = [order_agreement(medians, name) for name in others]
    run.keep(
        quality=quality,
        out_of_range=out_of_range_table(returns),
        swap=swap_table(results),
        shots=pd.DataFrame({"match": shots.matches, "wins": shots.wins}),
        scores=scores,
        importance=importance,
        calibration=calibration,
        receivers=receivers,
        medians=medians.reset_index(),
    )
    forest_scores = scores[scores["method"] == "forest"].set_index("outcome")["roc_auc"]
    run.write_metrics(
        {
            "returns": len(returns),
            "forest_roc_auc": {str(name): rounded(auc) for name, auc in forest_scores.items()},
        }
    )


def _validated(run: StageRun, shots: Shots) -> Validations:
    try:
        return validate(shots, run.params.shot_quality, run.seed)
    except ValueError as error:
        problem = f"{error}; ingest more games of the arena, or ask for fewer folds"
        raise InputError("params.yaml", problem, field="shot_quality.folds") from None


if __name__ == "__main__":
    run_stage(shot_quality)
