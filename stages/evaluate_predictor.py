"""Evaluate the predictors: forecast error over the horizon, on every set of measured balls."""

from collections.abc import Sequence
from functools import partial
from itertools import zip_longest
from typing import Any

import numpy as np
import pandas as pd

from models.arena.truth import Truth
from models.predictors.evaluation import SHOWN_HORIZONS_MS, ForecastErrors, errors_of, stacked
from models.predictors.protocol import FUTURE_TIMES, Forecast
from models.predictors.windows import Windows, windows
from models.segmentation.split import recording_groups
from pipeline.evaluation.contenders import ARENA, Contender, one_thread, read_contenders
from pipeline.evaluation.example_shots import MOST_SHOTS, Shot, write_shots
from pipeline.evaluation.example_shots import Forecast as ShownForecast
from pipeline.evaluation.figures.forecast_error import forecast_error_figure
from pipeline.evaluation.test_windows import MeasuredSet, read_test_sets
from pipeline.io.episodes import MeasuredEpisode
from pipeline.io.ground_truth import read_truth, true_windows
from pipeline.io.metrics import place, rounded
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar
from pipeline.runtime.stage_run import StageRun, run_stage

WINDOWS_AT_ONCE = 256
MEASURED, TRUTH = "measured", "truth"  # what forecasts are compared with

Results = dict[tuple[str, str], ForecastErrors]  # of a set, against what


@one_thread()
def evaluate_predictor(run: StageRun) -> None:
    """Forecast every test window with every predictor and report how far the forecasts are off."""
    settings, artifacts = run.params.evaluate_predictor, run.root / "artifacts"
    contenders = read_contenders(artifacts, settings)
    truth = read_truth(run.input("ingest", "truth.json"))
    sets = read_test_sets(artifacts, settings.window_every_ms / 1000)
    results: Results = {}
    for one in sets:
        run.log_input(one.name, run.input("segment", "samples.parquet"), len(one.windows))
        forecasts = _forecasts(one, [each for each in contenders if each.forecasts(one.name)])
        for against, judged in _judged_by(run, one, truth).items():
            results[one.name, against] = ForecastErrors(
                errors_of(forecasts, judged),
                one.recordings,
                one.windows.bounced[:, -1],
                settings.bootstrap_resamples,
                run.seed,
            )
    _report(run, sets, contenders, results)
    write_shots(run.artifact("shots.json"), _shots(sets, contenders, run.seed))


def _forecasts(one: MeasuredSet, contenders: Sequence[Contender]) -> dict[str, Forecast]:
    """Return each contender's forecast of all windows; the cores share them out."""
    history = one.windows.history
    starts = range(0, len(history), WINDOWS_AT_ONCE)
    tasks = [
        partial(contender.predictor.predict, history[start : start + WINDOWS_AT_ONCE])
        for contender in contenders
        for start in starts
    ]
    parts = []
    with progress_bar(f"forecasts on {one.name}", len(tasks)) as advance:
        for part in parallel(tasks):
            parts.append(part)
            advance()
    return {
        each.name: _joined(parts[k * len(starts) : (k + 1) * len(starts)])
        for k, each in enumerate(contenders)
    }


def _joined(parts: Sequence[Forecast]) -> Forecast:
    return Forecast(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.spin_measured for part in parts]),
    )


def _judged_by(run: StageRun, one: MeasuredSet, truth: Truth | None) -> dict[str, Windows]:
    """Return the windows with what forecasts are compared with: the same in all else."""
    judged = {MEASURED: one.windows}
    if one.name == ARENA and truth is not None:
        path = run.input("ingest", "true_contacts.parquet")
        judged[TRUTH] = true_windows(one.windows, one.recordings, truth, path)
    return judged


def _report(
    run: StageRun, sets: list[MeasuredSet], contenders: list[Contender], results: Results
) -> None:
    errors = stacked({key: one.over_horizon() for key, one in results.items()}, ["set", "against"])
    run.write_metrics(_metrics(errors))
    for one in sets:
        _add_figures(run, one, errors[errors["set"] == one.name])
    run.add_table(
        errors[errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)],
        "forecast_error",
        title="Forecast error at 100, 200 and 300 ms",
        caption="Position in mm, velocity in m/s, spin in rad/s; n windows. Simulated balls also "
        "against the true state, on the same windows.",
    )
    _add_difference_table(run, contenders, results)
    _add_group_table(run, sets, results)
    _add_predictor_table(run, contenders)


def _metrics(errors: pd.DataFrame) -> dict[str, Any]:
    """Return ``{set: {predictor: {quantity: {horizon_ms: {mean, std, n}}}}}`` over all windows."""
    metrics: dict[str, Any] = {}
    for row in errors[errors["bounce"] == "all"].to_dict("records"):
        label = _label(row["set"], row["against"])
        keys = (label, row["predictor"], row["quantity"], row["horizon_ms"])
        numbers = {"mean": rounded(row["mean"]), "std": rounded(row["std"]), "n": row["n"]}
        place(metrics, keys).update(numbers)
    return metrics


def _label(name: str, against: str) -> str:
    return name if against == MEASURED else f"{name}_{against}"


def _add_figures(run: StageRun, one: MeasuredSet, errors: pd.DataFrame) -> None:
    for against, rows in errors.groupby("against", sort=False):
        label = _label(one.name, str(against))
        state = "measured" if against == MEASURED else "true"
        run.add_figure(
            forecast_error_figure(rows.assign(set=label)),
            f"forecast_error_{label}",
            title=f"Forecast error on {one.name}, against the {state} state",
            caption=_caption(one, state),
        )


def _caption(one: MeasuredSet, state: str) -> str:
    caption = (
        f"Distance between forecast and {state} state over the horizon: mean over the test windows "
        "(line) with its 95 % interval bootstrapped over recordings (band), and standard "
        "deviation. A window counts as with a bounce where the ball meets the table within 300 ms. "
        f"{one.source.note}"
    )
    if one.source.spin == "per_recording":
        caption += (
            " A shot has one spin label, which holds until the ball first touches something or is "
            "lost from sight: the spin error shows only forecasts of a bounce that came later or "
            "not at all."
        )
    return caption


def _add_difference_table(run: StageRun, contenders: list[Contender], results: Results) -> None:
    differences = {
        (name,): one.differences(
            [other.name for other in contenders if other.trained_on and other.forecasts(name)]
        )
        for (name, against), one in results.items()
        if against == MEASURED
    }
    run.add_table(
        stacked(differences, ["set"]),
        "forecast_error_difference",
        title="Predictors that learned from balls beside the others",
        caption="Error of the predictor minus that of the other on the same windows, with its 95 % "
        "interval bootstrapped over recordings: negative where the predictor is better. "
        "lower_share is the share of all horizons from 100 to 300 ms at which its mean error is "
        "the lower one. Position in mm, velocity in m/s, spin in rad/s; n windows.",
    )


def _add_group_table(run: StageRun, sets: list[MeasuredSet], results: Results) -> None:
    frames = {}
    for one in sets:
        groups = recording_groups(pd.Series(one.recordings)).replace("", "all")
        frames[(one.name,)] = results[one.name, MEASURED].by_group(groups.to_numpy())
    run.add_table(
        stacked(frames, ["set"]),
        "forecast_error_by_group",
        title="Position error at 300 ms, by group of recordings",
        caption="Mean in mm with its 95 % interval bootstrapped over recordings; n windows.",
    )


def _add_predictor_table(run: StageRun, contenders: list[Contender]) -> None:
    rows = [
        {
            "predictor": one.name,
            "kind": one.kind,
            "simulator": one.simulator,
            "parameters": one.parameters,
            "starts from": one.starts_from,
            "trained on": ", ".join(one.trained_on) or None,
        }
        for one in contenders
    ]
    run.add_table(
        pd.DataFrame(rows).astype({"parameters": "Int64"}),
        "predictors",
        title="Predictors",
        caption="What flies a predictor's ball, or how many numbers it learned; and from which "
        "balls. Amended simulators forecast balls of the source that amended them. The oracle "
        "knows the hidden physics of the arena: a mark that no predictor is expected to pass.",
    )


def _shots(sets: list[MeasuredSet], contenders: list[Contender], seed: int) -> list[Shot]:
    """Draw episodes, the sets taking turns, and forecast each from its first window."""
    generator = np.random.default_rng(seed)
    drawn = []
    for one in sets:
        cuts = [(episode, windows(episode.episode, every=1.0)) for episode in one.episodes]
        usable = [(episode, cut) for episode, cut in cuts if len(cut)]
        drawn.append([usable[k] for k in generator.permutation(len(usable))])
    turns = [shot for turn in zip_longest(*drawn) for shot in turn if shot is not None]
    return [_shot(episode, cut, contenders) for episode, cut in turns[:MOST_SHOTS]]


def _shot(measured: MeasuredEpisode, cut: Windows, contenders: list[Contender]) -> Shot:
    good = ~measured.episode.outlier
    anchor = float(cut.anchors[0])
    ahead = [round(anchor + time, 6) for time in FUTURE_TIMES]
    forecasts = {
        one.name: ShownForecast(
            t=ahead, position=_points(one.predictor.predict(cut.history).states[0, :, :3])
        )
        for one in contenders
        if one.forecasts(measured.source)
    }
    return Shot(
        episode_id=measured.episode_id,
        source=measured.source,
        t=measured.episode.times[good].tolist(),
        measured=_points(measured.episode.positions[good]),
        anchor=anchor,
        forecasts=forecasts,
    )


def _points(positions: np.ndarray) -> list[tuple[float, float, float]]:
    return [(x, y, z) for x, y, z in np.round(positions, 5).tolist()]


if __name__ == "__main__":
    run_stage(evaluate_predictor)
