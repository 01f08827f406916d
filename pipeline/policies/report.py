"""The report of train_policy: metrics, figures, tables and their captions."""

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from rallygap.models.policy.scores import scores
from rallygap.models.policy.trial import TrialResult
from rallygap.models.robot.view import frames
from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.io.report_items import ReportAnimation, ReportFigure, ReportTable
from rallygap.pipeline.policies.figures.training import achieved_figure, learning_figure
from rallygap.pipeline.policies.training import VALIDATION_SHOTS, TrainingResult
from rallygap.pipeline.runtime.stage_run import StageRun

SETTING = ["group", "simulator", "horizons_ms"]  # shared by policies that differ only in the seed


def report_training(
    run: StageRun, results: Sequence[TrainingResult], tests: Sequence[TrialResult]
) -> None:
    """Write metrics, learning curves, an animation, figures of goals and the table of policies."""
    table = policies_table(results, tests)
    run.write_metrics(_metrics(table))
    curves = [one.curve.assign(**one.description.labels) for one in results]
    learning = ReportFigure(
        learning_figure(pd.concat(curves)),
        "learning",
        title="Learning curves of the policies",
        caption=f"After each training iteration a policy plays {VALIDATION_SHOTS} validation shots "
        "of its own simulator, without exploration noise. A control step is one action of one "
        "environment.",
    )
    policies = ReportTable(
        table,
        "policies",
        title="Trained policies",
        caption=f"Each policy plays {run.params.train_policy.trials} test shots of its own "
        "simulator with exact forecasts. A return lands on the far half; landing_error_m is the "
        "mean distance of returns from their goals. Slopes: of the speed and the topspin of "
        "returns over their goals, where there are such goals; 1 is perfect.",
    )
    animation = _animation(results[0], tests[0])
    run.add(learning, animation, *_goal_figures(run, results, tests), policies)


def policies_table(results: Sequence[TrainingResult], tests: Sequence[TrialResult]) -> pd.DataFrame:
    """Return one row a policy: its labels, how long it was trained, and its scores in a test."""
    rows = [
        {
            **one.description.labels,
            "control_steps": one.curve["control_steps"].iloc[-1],
            **scores(test.table),
        }
        for one, test in zip(results, tests, strict=True)
    ]
    return pd.DataFrame(rows)


def _metrics(table: pd.DataFrame) -> dict[str, Any]:
    """Return ``{group: {simulator: {horizons: {score: mean over seeds}}}}`` of two scores."""
    means = table.groupby(SETTING, sort=False, as_index=False)[["return_rate", "hit_rate"]].mean()
    return nested(means, SETTING)


def _animation(result: TrainingResult, test: TrialResult) -> ReportAnimation:
    """Show the first return among the recorded shots, or the first shot if there is none."""
    returned = test.table["returned"].to_numpy()[: len(test.motions)]
    shot = int(returned.argmax())
    return ReportAnimation(
        frames(test.motions[shot].joints, test.motions[shot].ball),
        "return",
        title="A return" if returned[shot] else "A miss",
        caption=f"The policy {result.description.name} plays a test shot, at half speed. Bullet "
        "simulates the arm, the ball simulator the ball.",
    )


def _goal_figures(
    run: StageRun, results: Sequence[TrainingResult], tests: Sequence[TrialResult]
) -> Iterator[ReportFigure]:
    """Yield a figure for each group with goals of speed or topspin."""
    for name, group in run.params.train_policy.groups.items():
        if group.goals.speed is None and group.goals.topspin is None:
            continue
        returns = [
            test.table[test.table["returned"]]
            for result, test in zip(results, tests, strict=True)
            if result.description.group == name
        ]
        yield ReportFigure(
            achieved_figure(pd.concat(returns)),
            f"achieved_{name}",
            title=f"Achieved values over goals: {name.replace('_', ' ')}",
            caption="Returns of test shots by all policies of the group: one dot per return, the "
            "least-squares line (solid) and the ideal (dashed).",
        )
