"""The report of sim2real: metrics, figures, tables and their captions."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from rallygap.pipeline.io.metrics import nested, place
from rallygap.pipeline.io.report_items import ReportFigure, ReportTable
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.figures.sim2real import transfer_figure
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_sets import ReplaySet
from rallygap.pipeline.transfer.replay_trials import ONCE
from rallygap.pipeline.transfer.transfer_table import BASELINE, PHYSICS, SETTING, paper_form_table

FIRST_BASELINE = {"predictor": PHYSICS, "protocol": ONCE}
KEYS = [*SETTING, *BASELINE]  # of an experiment


def report_transfer(run: StageRun, played: pd.DataFrame, learned: Sequence[str]) -> None:
    """Write metrics, the figure of rates, and the tables of rates and differences."""
    table = rates(played, KEYS)
    errors = played.groupby(KEYS, sort=False)["forecast_error_m"].mean()
    table["forecast_error_cm"] = 100 * errors.to_numpy()
    gains = differences(played, SETTING, BASELINE)
    over_first = differences(played, SETTING, FIRST_BASELINE)
    run.write_metrics(_metrics(table, gains))
    caption = _caption(run)
    run.add(
        ReportFigure(
            transfer_figure(table),
            "transfer",
            title="Sim-to-real: hits and returns of replayed shots",
            caption=caption,
        ),
        ReportTable(
            paper_form_table(table, learned),
            "transfer",
            title="Sim-to-real, in the form of the paper's table",
            caption=f"{caption} Numbers of shots, means over policies that differ only in the "
            "seed. Physics and the learned predictor both forecast at every control step. The "
            "paper has other shots, another robot and another policy: only the gains of the "
            "learned predictor compare.",
        ),
        ReportTable(
            table,
            "rates",
            title="Sim-to-real: all predictors",
            caption="Rates over the replayed shots with 95 % intervals (low, high) "
            "over trainings and recordings; hits and returns are numbers of shots, means over "
            "policies. "
            "forecast_error_cm: mean distance between forecast and true position at the middle "
            "horizon, over all control steps before the ball is out of play.",
        ),
        ReportTable(
            gains,
            "difference",
            title="Sim-to-real: gains over physics at every control step",
            caption="Difference of the rates with the predictor and with physics, paired by shot, "
            "with 95 % intervals over trainings and recordings. p_holm: Holm's "
            "correction of p for all comparisons of the table. gained, lost: shots with the "
            "outcome more often with the predictor, or with physics.",
        ),
        ReportTable(
            over_first,
            "difference_first_window",
            title="Sim-to-real: gains over physics from the first window",
            caption="As the table before, but the difference to physics that forecasts once, from "
            "the first window.",
        ),
    )


def report_sets(run: StageRun, sets: Sequence[ReplaySet]) -> None:
    """Add the table of replayed and excluded shots."""
    rows = [
        {
            "set": one.name,
            "replayed": len(one),
            "in_reach": one.in_reach,
            "rotated": one.rotated,
            "excluded": ", ".join(f"{count} {why}" for why, count in one.excluded.items()) or None,
            "spin": one.spin,
            "physics": "true" if one.oracle else "literature",
        }
        for one in sets
    ]
    run.add(
        ReportTable(
            pd.DataFrame(rows),
            "replayed",
            title="Replayed shots",
            caption="Shots that no predictor was trained on. in_reach: those that pass through the "
            "racket's workspace; the others are played, too. rotated: those that flew the other "
            "way and were rotated by half a turn. excluded: with the reason. spin: how it was "
            "measured; without labels a ball starts without spin, and its bounce changes the spin "
            "according to the change of velocity. physics: of the flight beyond the measurements "
            "and after the racket.",
        )
    )


def _caption(run: StageRun) -> str:
    simulator = run.params.sim2real.simulator
    return (
        f"Policies trained in the simulator {simulator} play measured shots. Physics: a Kalman "
        f"filter over the last 12 measurements with {simulator}; first window: one forecast of "
        "the whole flight from the first 12 measurements; every control step: a new forecast "
        "every 40 ms, as for all other predictors. Amended: the same filter with the simulator as "
        "close_gap amended it from the source's training shots. Oracle: the physics that flew "
        "the ball. After the racket, arena balls fly in the arena's physics, measured balls in the "
        "literature's."
    )


def _metrics(table: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """Return ``{set: {horizons: {predictor: {protocol: values}}}}``.

    The values of the rates' table, and ``gained_hits`` and ``gained_returns`` over physics. Holm's
    p-values are left out: they depend on the other rows of the table.
    """
    metrics = nested(table, KEYS)
    for key, rows in gains.groupby(KEYS, sort=False):
        gained = nested(rows.drop(columns=[*KEYS, "p_holm"]), ["outcome"])
        place(metrics, key).update({f"gained_{name}": values for name, values in gained.items()})
    return metrics
