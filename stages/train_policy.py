"""Train the policies: each in its own simulator, told the exact future of its balls."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from models.policy.motion_recording import film
from models.policy.random_streams import unseen_balls
from models.policy.scores import scores
from models.robot.view import frames
from pipeline.io.artifacts import write_table
from pipeline.io.metrics import over_seeds, place, rounded
from pipeline.io.simulators import load_simulator
from pipeline.policies.figures.training import achieved_figure, learning_figure
from pipeline.policies.storage import TrainedPolicy, save_policy
from pipeline.policies.training import (
    TRIALS,
    UNSEEN,
    Graduate,
    Pupil,
    train_policies,
    try_policies,
)
from pipeline.runtime.stage_run import StageRun, run_stage

SETTING = ["group", "simulator", "horizons_ms"]  # what policies of different seeds share


def train_policy(run: StageRun) -> None:
    """Train the policies of all groups, and let each play balls that it has never seen."""
    pupils = [
        Pupil(description, run.scratch(description.name)) for description in _descriptions(run)
    ]
    graduates = train_policies(pupils)
    played = try_policies(graduates, run.params.train_policy.trials)
    for one in graduates:
        save_policy(run.artifact(one.description.name), one.policy, one.description)
        run.timings[one.description.name] = {"training_cpu_s": round(one.seconds, 1)}
    write_table(run.artifact(UNSEEN), pd.concat(played, ignore_index=True))
    _report(run, graduates, played)


def _descriptions(run: StageRun) -> Iterator[TrainedPolicy]:
    """Yield what is to be trained; a repeat's seed is the same for all simulators and horizons."""
    for name, group in run.params.train_policy.groups.items():
        for simulator in group.simulators:
            for horizons in group.horizons_ms:
                for repeat in range(group.repeats):
                    yield TrainedPolicy(
                        group=name,
                        simulator=simulator,
                        effects=load_simulator(simulator).to_dict(),
                        horizons=horizons,
                        observation=group.observation,
                        goals=group.goals,
                        learning=group.learning,
                        seed=_seed(run.seed, repeat),
                        repeat=repeat,
                    )


def _seed(seed: int, repeat: int) -> int:
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0])


def _report(run: StageRun, graduates: Sequence[Graduate], played: Sequence[pd.DataFrame]) -> None:
    rows = [
        {**one.description.labels, "ticks": one.curve["ticks"].iloc[-1], **scores(balls)}
        for one, balls in zip(graduates, played, strict=True)
    ]
    results = pd.DataFrame(rows)
    run.write_metrics(_metrics(results))
    curves = [one.curve.assign(**one.description.labels) for one in graduates]
    run.add_figure(
        learning_figure(pd.concat(curves)),
        "learning",
        title="Learning curves of the policies",
        caption=f"After each leg of the training, a policy plays {TRIALS} balls of its own "
        "simulator from which it does not learn, without the noise of exploration. A control tick "
        "is one decision of one arm.",
    )
    _add_animation(run, graduates[0], played[0])
    _add_achieved_figures(run, graduates, played)
    run.add_table(
        results,
        "policies",
        title="Trained policies",
        caption=f"Each played {run.params.train_policy.trials} balls of its own simulator that it "
        "has never seen, told their exact future. Returns land on the far half; the landing error "
        "is their mean distance from the goal. Slopes: by how much the speed and the topspin of "
        "returns grow with what is asked for, where it is.",
    )


def _metrics(results: pd.DataFrame) -> dict[str, Any]:
    """Return ``{group: {simulator: {horizons: {score: mean over seeds}}}}``, of returns the spread.

    What cannot be told, such as the landing error of a policy that returned nothing, is left out.
    """
    metrics: dict[str, Any] = {}
    for setting, rows in results.groupby(SETTING, sort=False):
        others = rows.loc[:, "hit_rate":].mean().dropna()
        place(metrics, setting).update(
            return_rate=over_seeds(rows["return_rate"].tolist()),
            **{str(name): rounded(value) for name, value in others.items()},
        )
    return metrics


def _add_animation(run: StageRun, one: Graduate, played: pd.DataFrame) -> None:
    """Show the first of its balls that a policy returned; if it returned none, its first miss."""
    description, ball = one.description, int(played["returned"].to_numpy().argmax())
    balls, goals = description.task.practice(len(played), unseen_balls(description.seed))
    rows = slice(ball, ball + 1)
    shot = film(
        one.policy, description.task.simulator, balls[rows], goals[rows], description.observation
    )
    run.add_animation(
        frames(shot.joints, shot.ball),
        "return",
        title="A return" if shot.returned else "A miss",
        caption=f"The policy {description.name} and a ball that it has never seen, at half speed. "
        "Bullet moves the arm, the ball simulator the ball.",
    )


def _add_achieved_figures(
    run: StageRun, graduates: Sequence[Graduate], played: Sequence[pd.DataFrame]
) -> None:
    """Add a figure for each group that is asked for speed or topspin."""
    for name, group in run.params.train_policy.groups.items():
        if group.goals.speed is None and group.goals.topspin is None:
            continue
        balls = [
            table[table["returned"]]
            for one, table in zip(graduates, played, strict=True)
            if one.description.group == name
        ]
        run.add_figure(
            achieved_figure(pd.concat(balls)),
            f"achieved_{name}",
            title=f"What is achieved and what was asked for: {name.replace('_', ' ')}",
            caption="Returns of all policies of the group, on balls that they have never seen: a "
            "dot each, with the fitted line (solid) and what would be perfect (dashed).",
        )


if __name__ == "__main__":
    run_stage(train_policy)
