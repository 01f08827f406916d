"""The report of sim2sim: metrics, figure, tables and their captions."""

from typing import Any

import numpy as np
import pandas as pd

from rallygap.pipeline.io.metrics import over_seeds, place, rounded
from rallygap.pipeline.io.report_items import ReportFigure, ReportTable
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.figures.sim2sim import IMPERFECT, PROTOCOLS, sim2sim_figure
from rallygap.pipeline.transfer.rates import differences, rates

SETTING = ["protocol", "simulator", "horizons_ms"]  # of a comparison
BASELINE = {"predictor": IMPERFECT}
KEYS = [*SETTING, *BASELINE]  # of an experiment
INTERVAL = {"return_rate_low": "ci_low", "return_rate_high": "ci_high"}
COLUMNS = ["return_rate", "std", "ci_low", "ci_high", "hit_rate", "forecast_error_m"]


def report_sim2sim(run: StageRun, played: pd.DataFrame) -> None:
    """Write metrics, the figure of return rates, and the tables of rates and differences."""
    table = _rates(played)
    gains = differences(played, SETTING, BASELINE)
    gains = gains[gains["outcome"] == "returns"]
    run.write_metrics(_metrics(table, gains))
    caption = _caption(run)
    run.add(
        ReportFigure(
            sim2sim_figure(table),
            "return_rate",
            title="Sim-to-sim transfer",
            caption=f"{caption} Whiskers: 95 % intervals over trainings and shots. "
            "Dots, if there are several policies: policies that differ only in the seed.",
        ),
        ReportTable(
            table[[*KEYS, *COLUMNS]],
            "return_rate",
            title="Sim-to-sim: returns, hits and forecast errors",
            caption=f"{caption} Rates over all shots; ci: 95 % interval of the return rate "
            "over trainings and shots; std: over policies that differ only in the "
            "seed; forecast_error_m: mean distance between forecast and true position at the "
            "middle horizon, over all control steps before the ball is out of play.",
        ),
        ReportTable(
            gains.drop(columns=["predictor", "outcome"]),
            "difference",
            title="Sim-to-sim: gain of the ground truth's predictions",
            caption="Return rate with the ground truth's predictions minus that with the imperfect "
            "simulator's, paired by shot, with 95 % intervals over trainings and "
            "shots. gained, lost: shots returned more often with the one, or with the other.",
        ),
    )


def _rates(played: pd.DataFrame) -> pd.DataFrame:
    """Return ``rates`` with the single policies' return rates and the forecast errors."""
    table = rates(played, KEYS)
    experiments = played.groupby(KEYS, sort=False)
    per_seed = [part.groupby("repeat")["returned"].mean().tolist() for _, part in experiments]
    return table.rename(columns=INTERVAL).assign(
        per_seed=pd.Series(per_seed),
        std=[np.std(each) for each in per_seed],
        # To a micrometre: the ground truth's own forecasts differ from it by rounding alone.
        forecast_error_m=experiments["forecast_error_m"].mean().round(6).to_numpy(),
    )


def _metrics(table: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """Return ``{protocol: {simulator: {horizons: {predictor: {...}, "difference": {...}}}}}``."""
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        place(metrics, [row[key] for key in KEYS]).update(
            return_rate=over_seeds(row["per_seed"]), hit_rate=rounded(row["hit_rate"])
        )
    for row in gains.to_dict("records"):
        place(metrics, [*(row[key] for key in SETTING), "difference"]).update(
            mean=rounded(row["difference"]),
            low=rounded(row["ci_low"]),
            high=rounded(row["ci_high"]),
        )
    return metrics


def _caption(run: StageRun) -> str:
    settings = run.params.sim2sim
    protocols = "; ".join(f"{name}: {PROTOCOLS[name]}" for name in settings.protocols)
    return (
        "Policies trained in an imperfect simulator play the same "
        f"{settings.episodes} test shots, which the simulator {settings.ground_truth} flies to the "
        "robot and back. The predictor is either that ground truth or the policy's own imperfect "
        f"simulator. {protocols}."
    )
