"""What a sweep found: parameters that params.yaml can take, all trials, and two figures."""

from collections.abc import Iterator
from typing import Any

import optuna
import pandas as pd
import yaml
from optuna.trial import FrozenTrial, TrialState

from pipeline.experiments.profiles import flags, merged
from pipeline.io.artifacts import write_csv, write_json, write_text
from pipeline.io.figure_style import apply_style, save_figure
from pipeline.io.metrics import rounded
from pipeline.runtime.errors import InputError
from pipeline.sweeps.figures.trials import history_figure, importance_figure
from pipeline.sweeps.plan import Plan, nested

BEST, TRIALS, SUMMARY = "best_params.yaml", "trials.csv", "sweep.json"
HISTORY, IMPORTANCE = "history.png", "importance.png"
CONFIRMED, CONFIRMED_SUMMARY = "confirmed.csv", "confirmed.json"  # see confirm.py
OUTCOMES = {TrialState.COMPLETE: "finished", TrialState.PRUNED: "given up"}


def write_report(plan: Plan, study: optuna.Study) -> list[str]:
    """Write ``reports/sweeps/<name>``.

    Returns:
        The best parameters as flags of ``dvc exp run``; none where those of params.yaml did best.

    Raises:
        InputError: no trial was finished.
    """
    trials = trials_table(plan, study)
    if "finished" not in set(trials["outcome"]):
        raise InputError(f"sweep {plan.name}", "no trial was finished: all lagged behind or failed")
    best = plan.suggested(study.best_trial)
    _forget_outdated(plan, best)
    write_text(plan.report / BEST, _best_text(plan, best))
    write_csv(plan.report / TRIALS, trials)
    write_json(plan.report / SUMMARY, _summary(plan, study, trials))
    apply_style()
    save_figure(plan.report / HISTORY, history_figure(trials, plan.settings))
    importances = _importances(study)
    if importances:
        save_figure(plan.report / IMPORTANCE, importance_figure(importances))
    return flags(plan.params, merged(plan.params, nested(best)))


def trials_table(plan: Plan, study: optuna.Study) -> pd.DataFrame:
    """Return one row a trial that came to an end of its own.

    Columns: ``trial``, which counts them; ``outcome``; ``steps``, after which it ended; ``score``,
    the last one; and a column a parameter, what was tried.
    """
    rows = list(_rows(plan, study.get_trials(deepcopy=False)))
    return pd.DataFrame(rows, columns=["trial", "outcome", "steps", "score", *plan.settings.space])


def _rows(plan: Plan, trials: list[FrozenTrial]) -> Iterator[dict[str, Any]]:
    for trial in trials:
        if trial.state in OUTCOMES:
            yield {
                "trial": trial.number,
                "outcome": OUTCOMES[trial.state],
                "steps": trial.last_step or 0,
                "score": trial.value,
                **plan.suggested(trial),
            }


def _summary(plan: Plan, study: optuna.Study, trials: pd.DataFrame) -> dict[str, Any]:
    settings = plan.settings
    return {
        "sweep": plan.name,
        "study": study.study_name,
        "score": settings.score,
        "direction": settings.direction,
        "trials": {str(name): int(n) for name, n in trials["outcome"].value_counts().items()},
        "best_trial": study.best_trial.number,
        "best_score": rounded(study.best_value),
        "params_score": _params_score(plan, trials),
        "settings": settings.model_dump(mode="json"),
    }


def _params_score(plan: Plan, trials: pd.DataFrame) -> float | None:
    """Return the score of what params.yaml says, if it was tried to the end."""
    wanted = plan.defaults()
    for row in trials[trials["outcome"] == "finished"].to_dict("records"):
        if wanted is not None and all(row[key] == value for key, value in wanted.items()):
            return rounded(row["score"])
    return None


def _importances(study: optuna.Study) -> dict[str, float]:
    """Return the share of each parameter in how scores vary; none where too few were finished."""
    try:
        found = optuna.importance.get_param_importances(study)
    except (ValueError, RuntimeError):
        return {}
    return {name: share for name, share in found.items() if share == share}


def _forget_outdated(plan: Plan, best: dict[str, Any]) -> None:
    """Remove what an earlier sweep of this name left that this one may not replace."""
    path = plan.report / BEST
    if path.is_file() and path.read_text(encoding="utf-8") != _best_text(plan, best):
        for name in (IMPORTANCE, CONFIRMED, CONFIRMED_SUMMARY):
            (plan.report / name).unlink(missing_ok=True)


def _best_text(plan: Plan, best: dict[str, Any]) -> str:
    heading = (
        f"# The best trial of `rallygap sweep {plan.name}`. What holds up in\n"
        f"# `rallygap confirm {plan.name}` may go into params.yaml.\n"
    )
    return heading + str(yaml.safe_dump(nested(best), sort_keys=False))
