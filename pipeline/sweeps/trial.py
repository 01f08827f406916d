"""One trial: a short training with suggested parameters, scored and recorded in MLflow."""

import math
import signal
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import optuna
import typer
from optuna import TrialPruned

from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.sweeps.settings import PredictorSweep, Sweep, Train
from rallygap.pipeline.sweeps.study import PROCESS
from rallygap.pipeline.tracking.recording import ParentRun, RunStart, recording, this_process
from rallygap.pipeline.tracking.results import Results


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


def run_trial(sweep: Sweep, train: Train, trial: optuna.Trial) -> float:
    """Run a trial and return its score.

    Args:
        sweep: the sweep.
        train: the training.
        trial: Optuna's.

    Raises:
        TrialPruned: the score is not finite or worse than the median of the other trials, or the
            suggested values are invalid together.
        SystemExit: the user interrupted it; the next command runs the trial again.
    """
    settings, scores = sweep.settings, dict[str, float]()

    def report(step: int, score: float) -> None:
        scores[str(step)] = score
        trial.report(score, step)
        if not math.isfinite(score) or trial.should_prune():
            raise TrialPruned(f"{settings.score} {score:.4g} after {settings.step} {step}")

    trial.set_user_attr(PROCESS, this_process())
    try:
        params = sweep.trial_params(sweep.suggest(trial))
    except InputError as error:
        raise TrialPruned(str(error)) from None
    start = _mlflow_run(sweep, trial, params)
    metric = settings.score.replace(" ", "_")
    with recording(start, lambda: Results({metric: scores})), TemporaryDirectory() as checkpoints:
        try:
            result: float | TrialPruned = train(params, Path(checkpoints), report)
        except TrialPruned as pruned:  # for MLflow the run is finished
            result = pruned
        except KeyboardInterrupt:  # Optuna would take the trial for a failed one
            raise SystemExit(128 + signal.SIGINT) from None
    if isinstance(result, TrialPruned):
        typer.echo(f"trial {trial.number}: pruned, {result}")
        raise result
    typer.echo(f"trial {trial.number}: {settings.score} {result:.4g}")
    return result


def _mlflow_run(sweep: Sweep, trial: optuna.Trial, params: Params) -> RunStart:
    """Return the description of a trial's MLflow run, nested in the run of the sweep."""
    study, command = trial.study.study_name, f"rallygap sweep {sweep.name}"
    commit = git_commit(sweep.root)
    shared = {"mlflow.source.name": command}
    if commit:
        shared["mlflow.source.git.commit"] = commit
    own = {"rallygap.study": study, "rallygap.trial": str(trial.number)}
    used = params.model_dump(mode="json", include={"seed", sweep.settings.stage})
    parent = ParentRun(study, command, shared)
    return RunStart(f"trial {trial.number}", used, {**shared, **own}, parent)
