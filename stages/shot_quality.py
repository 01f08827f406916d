"""Shot quality: how fast, spun, flat and hard to return the replayed balls come back."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.arena.truth import draw_truth
from models.shot_quality.forest import Forest, grown
from models.shot_quality.forest_evaluation import base_rate, forest, logistic
from models.shot_quality.receivers import RECEIVERS, played_against
from models.shot_quality.shots import Shots
from pipeline.io.artifacts import write_table
from pipeline.io.metrics import place, rounded
from pipeline.runtime.console import warn
from pipeline.runtime.errors import InputError
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.shot_quality.figures.returns import calibration_figure, medians_figure
from pipeline.shot_quality.forest_storage import TrainedForest, save_forest
from pipeline.shot_quality.professionals import read_professionals
from pipeline.shot_quality.tables import (
    KEYS,
    METRICS,
    Judged,
    calibration_table,
    experiments,
    importance_table,
    judged,
    order_kept,
    quality_table,
    return_features,
    returns_table,
    score_rows,
    swap_table,
    unlike_table,
    win_medians,
)
from pipeline.transfer.returns import read_played

ANOTHER_HALL = 1  # added to the seed: the arena's own stays sealed
MEASURED, POINT, USUAL = "as_measured", "point", RECEIVERS[0].name


def shot_quality(run: StageRun) -> None:
    """Grow the forest on professionals' points, and judge all returns of sim2real."""
    played = read_played(run.input("sim2real", "played.parquet"))
    shots = read_professionals(run.root / "artifacts")
    run.log_input("returns of professionals", run.input("ingest", "points.parquet"), len(shots))
    methods = _judged(run, shots)
    own = _grown(run, shots, shots.wins)
    _keep(run, own, shots)
    returns = returns_table(played, own)
    if not len(returns):
        warn("no ball of sim2real was returned, so there are no medians; train policies for longer")
    write_table(run.artifact("returns.parquet"), returns)
    found = experiments(played, returns, run.params.shot_quality.bootstrap_resamples, run.seed)
    quality = quality_table(found)
    _report_quality(run, quality, returns)
    _report_swap(run, swap_table(found))
    scores = _report_forest(run, shots, methods)
    forests = {MEASURED: own, POINT: _grown(run, shots, shots.point)}
    receivers = _report_receivers(run, played, returns, forests)
    run.write_metrics(_metrics(quality, scores, receivers))


def _judged(run: StageRun, shots: Shots) -> dict[str, list[Judged]]:
    """Return what every method makes of both outcomes of shots that it has not seen."""
    settings = run.params.shot_quality
    methods = {
        "base_rate": base_rate,
        "logistic": logistic,
        "forest": forest(settings.forest, run.seed),
    }
    try:
        return {
            "wins": judged(shots, shots.wins, methods, settings.folds),
            "point": judged(shots, shots.point, methods, settings.folds),
        }
    except ValueError as error:
        problem = f"{error}; ingest more games of the arena, or ask for fewer folds"
        raise InputError("params.yaml", problem, field="shot_quality.folds") from None


def _grown(run: StageRun, shots: Shots, wins: NDArray[np.bool_]) -> Forest:
    return grown(shots.features, wins, run.params.shot_quality.forest, run.seed)


def _keep(run: StageRun, own: Forest, shots: Shots) -> None:
    described = TrainedForest(
        shots=len(shots),
        matches=len(np.unique(shots.matches)),
        settings=run.params.shot_quality.forest,
        seed=run.seed,
    )
    save_forest(run.artifact("forest"), own, described)


def _report_quality(run: StageRun, quality: pd.DataFrame, returns: pd.DataFrame) -> None:
    caption = (
        "Medians over all successful returns of sim2real, with 95 % intervals bootstrapped over "
        "balls, each with what all policies make of it. Speed and spin rate are those just after "
        "the racket; clearance is the gap between ball and net. The winning probability is a "
        "forest's: the chance that a professional of the arena wins the point with such a shot. "
        "Each predictor returns balls of its own, so the medians are of different balls."
    )
    run.add_figure(
        medians_figure(quality[quality["protocol"] == "every_tick"], dict(METRICS)),
        "quality",
        title="Shot quality: medians of four metrics",
        caption=f"{caption} Hatched: the nearer horizons, as in the paper. All predictors are "
        "asked at every tick.",
    )
    run.add_table(
        quality,
        "quality",
        title="Shot quality",
        caption=f"{caption} returns: mean number over policies. unlike: share of the returns of "
        "which some feature is beyond all that the forest was trained on; there its probability "
        "is that of the nearest shots it knows.",
    )
    run.add_table(
        unlike_table(returns),
        "unlike",
        title="Returns that are unlike any shot of the professionals",
        caption="Share of the returns of which a feature is below the smallest or above the "
        "largest value among the shots that the forest was trained on. A return may be unlike all "
        "of these in its combination of features and not be counted.",
    )


def _report_swap(run: StageRun, times: pd.DataFrame) -> None:
    run.add_table(
        times,
        "swap",
        title="Shot quality: what the swap changes",
        caption="The median of another predictor divided by that of physics, asked at every tick: "
        "1 is no change. The 95 % intervals are bootstrapped over balls, the same ones for both. "
        "Each predictor returns balls of its own, so a change is of the returns, not of the same "
        "ball's return.",
    )


def _report_forest(
    run: StageRun, shots: Shots, methods: Mapping[str, list[Judged]]
) -> pd.DataFrame:
    settings = run.params.shot_quality
    outcomes = {"wins": shots.wins, "point": shots.point}
    scores = pd.DataFrame(
        [
            {"outcome": outcome, **row}
            for outcome, wins in outcomes.items()
            for row in score_rows(
                shots, wins, methods[outcome], settings.bootstrap_resamples, run.seed
            )
        ]
    )
    curve = calibration_table(shots, methods["wins"][1:])  # the base rate tells no shots apart
    judged_on = (
        f"Good returns of professionals, {len(shots)} from {len(np.unique(shots.matches))} "
        f"matches, each judged by a model that has not seen its match ({settings.folds} parts). "
    )
    run.add_figure(
        calibration_figure(curve, float(shots.wins.mean())),
        "calibration",
        title="Do shots win as often as they are said to?",
        caption=f"{judged_on}A point is an eighth of the shots, by the probability given to them.",
    )
    run.add_table(curve, "calibration", title="Calibration", caption=judged_on)
    run.add_table(
        scores,
        "scores",
        title="How well winning shots are told",
        caption=f"{judged_on}outcome wins: the point was won with the very shot, which is what "
        "the forest tells; point: it was won in the end, which later shots decide. share: of the "
        "shots that did. ROC-AUC: 0.5 is blind, and the base rate a little below, because it is "
        "that of all other matches. Brier score: smaller is better. 95 % intervals "
        "(low, high) are bootstrapped over matches.",
    )
    run.add_table(
        importance_table(shots, methods["wins"][-1].parts, run.seed),
        "importance",
        title="What the forest goes by",
        caption=f"{judged_on}Fall of the ROC-AUC where a feature is shuffled among shots, mean "
        "and standard deviation of five shuffles. Features that go together stand in for one "
        "another: where one is shuffled, the other still tells, so both seem to matter less than "
        "they do, and shuffling makes shots that nobody plays. goes_with: the feature of the "
        "strongest rank correlation.",
    )
    return scores


def _report_receivers(
    run: StageRun, played: pd.DataFrame, returns: pd.DataFrame, own: Mapping[str, Forest]
) -> pd.DataFrame:
    settings = run.params.shot_quality
    table, others = _against(run)
    forests = {**own, **others}
    features = return_features(played[played["returned"]])
    medians = win_medians(returns, features, forests)
    table["order_kept"] = [order_kept(medians, name, USUAL) for name in table["receiver"]]
    told = (
        f"Forests that were grown on {settings.points} points each, between professionals and a "
        "receiver whose reach or errors are a third smaller or larger, in a hall that is not the "
        "arena's. Only shots of the professionals count, the same ones each time."
    )
    run.add_table(
        table,
        "receivers",
        title="What if the receiver were another one?",
        caption=f"{told} reach, error: factors. share: of the shots that won. order_kept: share "
        "of the pairs of predictors, on the same set and horizons, of whose medians the same one "
        "is larger as with the usual receiver. usual_again: the usual one on other points, which "
        "tells what chance changes.",
    )
    run.add_table(
        medians.reset_index(),
        "win_probability",
        title="Winning probabilities with other receivers and labels",
        caption=f"Medians over the returns. {told} as_measured: the forest of the other tables. "
        "point: the same shots, labelled by who won the point in the end.",
    )
    return table


def _against(run: StageRun) -> tuple[pd.DataFrame, dict[str, Forest]]:
    """Play against every receiver; return how that went, and the forests by receiver."""
    hall = draw_truth(run.seed + ANOTHER_HALL)
    rows, forests = [], {}
    for one in RECEIVERS:
        random = np.random.default_rng([run.seed, *b"receivers", one.draw])
        shots = played_against(one, hall, run.params.shot_quality.points, random)
        forests[one.name] = _grown(run, shots, shots.wins)
        rows.append({**asdict(one), "shots": len(shots), "share": shots.wins.mean()})
    return pd.DataFrame(rows).rename(columns={"name": "receiver"}), forests


def _metrics(
    quality: pd.DataFrame, scores: pd.DataFrame, receivers: pd.DataFrame
) -> dict[str, Any]:
    """Return the numbers of the tables under what they belong to; what is not known is left out."""
    metrics: dict[str, Any] = {}
    _enter(place(metrics, ["returns"]), quality, KEYS)
    _enter(place(metrics, ["scores"]), scores, ["outcome", "method"])
    _enter(place(metrics, ["receivers"]), receivers, ["receiver"])
    return metrics


def _enter(metrics: dict[str, Any], table: pd.DataFrame, keys: list[str]) -> None:
    for row in table.to_dict("records"):
        numbers = {str(name): value for name, value in row.items() if name not in keys}
        known = {name: rounded(value) for name, value in numbers.items() if np.isfinite(value)}
        place(metrics, [row[key] for key in keys]).update(known)


if __name__ == "__main__":
    run_stage(shot_quality)
