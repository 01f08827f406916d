"""One trial: a short training with suggested parameters, scored and recorded in MLflow."""

import math
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import optuna
import typer
from optuna import TrialPruned

from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.sweeps.settings import PredictorSweep, Sweep
from rallygap.pipeline.tracking.recording import ParentRun, Results, RunStart, recording

Report = Callable[[int, float], None]
"""Takes the score after each epoch or iteration, counted from 1; raises ``TrialPruned``."""

Train = Callable[[Params, Path, Report], float]
"""Trains with parameters in a folder for checkpoints, and returns the final score."""


def training_of(sweep: Sweep) -> Train:
    """Return the training of a sweep's trials, with its data in memory.

    Raises:
        InputError: the data are missing.
    """
    if isinstance(sweep.settings, PredictorSweep):
        from rallygap.pipeline.sweeps.predictor import PredictorTraining

        return PredictorTraining(sweep.root, sweep.settings, sweep.trial_params({})).score
    from rallygap.pipeline.sweeps.policy import score_policy

    return partial(score_policy, sweep.settings)


def run_trial(
    sweep: Sweep, train: Train, check_parent: Callable[[], None], trial: optuna.Trial
) -> float:
    """Run a trial and return its score.

    Args:
        sweep: the sweep.
        train: the training.
        check_parent: called after every step; ends the process if its parent has died.
        trial: Optuna's.

    Raises:
        TrialPruned: the score is not finite or worse than the median of the other trials, or the
            suggested values are invalid together.
    """
    settings, scores = sweep.settings, dict[str, float]()

    def report(step: int, score: float) -> None:
        check_parent()
        scores[str(step)] = score
        trial.report(score, step)
        if not math.isfinite(score) or trial.should_prune():
            raise TrialPruned(f"{settings.score} {score:.4g} after {settings.step} {step}")

    try:
        params = sweep.trial_params(sweep.suggest(trial))
    except InputError as error:
        raise TrialPruned(str(error)) from None
    start = _mlflow_run(sweep, trial, params)
    metric = settings.score.replace(" ", "_")
    folder = sweep.scratch / "trials"
    folder.mkdir(parents=True, exist_ok=True)
    with (
        recording(start, lambda: Results({metric: scores})),
        tempfile.TemporaryDirectory(dir=folder) as checkpoints,
    ):
        try:
            result: float | TrialPruned = train(params, Path(checkpoints), report)
        except TrialPruned as pruned:  # for MLflow the run is finished
            result = pruned
    if isinstance(result, TrialPruned):
        typer.echo(f"trial {trial.number}: pruned, {result}")
        raise result
    typer.echo(f"trial {trial.number}: {settings.score} {result:.4g}")
    return result


def _mlflow_run(sweep: Sweep, trial: optuna.Trial, params: Params) -> RunStart:
    """Return the description of a trial's MLflow run, nested in the run of the sweep."""
    study, command = trial.study.study_name, f"rallygap sweep {sweep.name}"
    commit = git_commit(sweep.root)
    shared = {"mlflow.source.git.commit": commit} if commit else {}
    own = {"rallygap.study": study, "rallygap.trial": str(trial.number)}
    used = params.model_dump(mode="json", include={"seed", sweep.settings.stage})
    parent = ParentRun(study, command, command, shared, failure_is_final=False)
    tags = {**shared, **own, "mlflow.source.name": command}
    return RunStart(f"trial {trial.number}", used, tags, parent)
