"""The report of a sweep: best parameters as params.yaml takes them, all trials, a figure."""

from collections.abc import Mapping

import optuna
import pandas as pd
import yaml
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.trial import TrialState

from rallygap.pipeline.io.artifacts import write_csv, write_json, write_text
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.profiles import flags, merged
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.settings import Sweep, nested
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED, apply_style, save_figure

BEST, TRIALS, SUMMARY = "best_params.yaml", "trials.csv", "sweep.json"
FIGURE = "trials.png"
CONFIRMED, CONFIRMED_SUMMARY = "confirmed.csv", "confirmed.json"  # of `rallygap confirm`
MIN_COMPLETED = 20  # trials; importance compares their best tenth with all
HEIGHT = 3.4  # inch
BLUE, ORANGE = "#0f7fc4", "#d55e00"
OUTCOMES = {TrialState.COMPLETE: "completed", TrialState.PRUNED: "pruned"}


def write_report(sweep: Sweep, study: optuna.Study) -> list[str]:
    """Write ``reports/sweeps/NAME``.

    Returns:
        The best parameters as flags of ``dvc exp run``; none if params.yaml has them.

    Raises:
        InputError: no trial was completed.
    """
    trials = trials_table(sweep, study)
    if "completed" not in set(trials["outcome"]):
        raise InputError(f"sweep {sweep.name}", "no trial was completed: all were pruned or failed")
    best = nested(sweep.suggest(study.best_trial))
    text = (
        f"# The best trial of `rallygap sweep {sweep.name}`. Run `rallygap confirm {sweep.name}`\n"
        "# before it goes into params.yaml.\n"
    ) + str(yaml.safe_dump(best, sort_keys=False))
    path = sweep.report / BEST
    if path.is_file() and read_yaml(path) != best:
        for name in (CONFIRMED, CONFIRMED_SUMMARY):  # of an earlier result
            (sweep.report / name).unlink(missing_ok=True)
    write_text(path, text)
    write_csv(sweep.report / TRIALS, trials)
    params_score = _params_score(sweep, trials)
    summary = {
        "sweep": sweep.name,
        "study": study.study_name,
        "score": sweep.settings.score,
        "direction": sweep.settings.direction,
        "trials": {str(name): int(n) for name, n in trials["outcome"].value_counts().items()},
        "best_trial": study.best_trial.number,
        "best_score": rounded(study.best_value),
        "params_score": params_score,
        "settings": sweep.settings.model_dump(mode="json"),
    }
    write_json(sweep.report / SUMMARY, summary)
    completed = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    importance = {}
    if len(completed) >= MIN_COMPLETED:
        importance = get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())
    figure = sweep_figure(trials, importance, sweep.settings.score, params_score)
    save_figure(sweep.report / FIGURE, figure)
    return flags(sweep.params, merged(sweep.params, best))


def trials_table(sweep: Sweep, study: optuna.Study) -> pd.DataFrame:
    """Return one row per completed or pruned trial.

    Columns: ``trial``, its number; ``outcome``; ``steps``, epochs or training iterations;
    ``score``, the last one; and one column per searched parameter.
    """
    rows = [
        {
            "trial": trial.number,
            "outcome": OUTCOMES[trial.state],
            "steps": trial.last_step or 0,
            "score": trial.value,
            **sweep.suggest(trial),
        }
        for trial in study.get_trials(deepcopy=False, states=tuple(OUTCOMES))
    ]
    return pd.DataFrame(rows, columns=["trial", "outcome", "steps", "score", *sweep.settings.space])


def _params_score(sweep: Sweep, trials: pd.DataFrame) -> float | None:
    """Return the score of params.yaml, if that trial was completed."""
    values = sweep.defaults()
    for row in trials[trials["outcome"] == "completed"].to_dict("records"):
        if values is not None and all(row[key] == value for key, value in values.items()):
            return rounded(row["score"])
    return None


def sweep_figure(
    trials: pd.DataFrame, importance: Mapping[str, float], score: str, params_score: float | None
) -> Figure:
    """Draw the score of every trial and, if it is known, the importance of the parameters.

    Args:
        trials: columns ``trial``, ``outcome`` and ``score``.
        importance: of the parameters, by name; empty if unknown.
        score: name of the scores.
        params_score: of ``params.yaml``, if known.
    """
    apply_style()
    figure = Figure(figsize=(FIGURE_WIDTH, HEIGHT))
    axes, *others = figure.subplots(1, 2 if importance else 1, squeeze=False)[0]
    for outcome, marker, colour, label in (
        ("completed", "o", BLUE, "completed"),
        ("pruned", "x", MUTED, "pruned, at its last step"),
    ):
        rows = trials[trials["outcome"] == outcome]
        axes.plot(rows["trial"], rows["score"], marker, color=colour, ms=5, label=label)
    if params_score is not None:
        axes.axhline(params_score, color=ORANGE, lw=1.2, ls="--", label="params.yaml")
    axes.set(xlabel="trial", ylabel=score)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(fontsize=8)
    for panel in others:
        names = [name.rpartition(".")[2] for name in importance]
        bars = panel.barh(names, list(importance.values()), color=BLUE, height=0.6)
        panel.bar_label(bars, fmt="%.2f", padding=3, fontsize=8)
        panel.invert_yaxis()
        panel.grid(visible=False, axis="y")
        panel.margins(x=0.15)
        count = int((trials["outcome"] == "completed").sum())
        panel.set_xlabel(f"importance (PED-ANOVA, n = {count})")
    return figure
