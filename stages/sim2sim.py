"""Sim-to-sim: policies from imperfect simulators play in another, which counts as the truth."""

from typing import Any

import numpy as np
import pandas as pd

from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.policies.storage import load_policies
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.trials import IMPERFECT, joined, run_trials, sim2sim_trials

SETTING = ["protocol", "simulator", "horizons_ms"]  # of a comparison
BASELINE = {"predictor": IMPERFECT}
KEYS = [*SETTING, *BASELINE]  # of an experiment
INTERVAL = {"return_rate_low": "ci_low", "return_rate_high": "ci_high"}


def sim2sim(run: StageRun) -> None:
    """Let every policy play the same shots, with the truth and its own simulator as predictors."""
    group, folder = run.params.sim2sim.group, run.input("train_policy", "")
    policies = load_policies(folder, group)
    run.log_input(f"policies of {group}", folder, len(policies))
    played = joined(run_trials(sim2sim_trials(run, policies)))
    gains = differences(played, SETTING, BASELINE)
    gains = gains[gains["outcome"] == "returns"].drop(columns=["predictor", "outcome"])
    run.keep(rates=_rates(played), differences=gains)
    run.write_metrics(_metrics(gains))


def _rates(played: pd.DataFrame) -> pd.DataFrame:
    """Return ``rates`` with the single policies' return rates and the forecast errors."""
    table = rates(played, KEYS)
    experiments = played.groupby(KEYS, sort=False)
    per_seed = [part.groupby("repeat")["returned"].mean().tolist() for _, part in experiments]
    return table.rename(columns=INTERVAL).assign(
        per_seed=pd.Series(per_seed),
        std=[np.std(shares) for shares in per_seed],
        # To a micrometre: the ground truth's own forecasts differ from it by rounding alone.
        forecast_error_m=experiments["forecast_error_m"].mean().round(6).to_numpy(),
    )


def _metrics(gains: pd.DataFrame) -> dict[str, Any]:
    """Return ``{protocol: gain of the return rate}``, means over simulators and horizons."""
    means = gains.groupby("protocol", sort=False)["difference"].mean()
    return {str(protocol): {"gain": rounded(gain)} for protocol, gain in means.items()}


if __name__ == "__main__":
    run_stage(sim2sim)
