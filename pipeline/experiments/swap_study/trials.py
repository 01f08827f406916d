"""The trials of the study: who forecasts, how often, how late actions are, how wrong labels are."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd

from rallygap.models.policy.incoming_balls import CONTROL_STEP
from rallygap.models.predictors.protocol import Predictor
from rallygap.models.replay.replayed_balls import with_label_error
from rallygap.pipeline.transfer.replay_sets import ReplaySet
from rallygap.pipeline.transfer.replay_trials import (
    EVERY_STEP,
    EVERY_STEPS,
    ONCE,
    Forecaster,
    Policies,
    ReplayTrial,
    replay_trials,
)

STEP_MS = round(1000 * CONTROL_STEP)
INTERVALS_MS = (40, 80, 160, 320, None)  # from one forecast to the next; None: there is no next
# An arm takes a command every 20 ms.
LATENCIES_MS = (0, 40, 100, 200)
LABEL_ERRORS = (0.0, 0.2)  # of a component of all labels of a ball, as a share of the spin
OF_MECHANISM = ("physics_c", "amended", "transformer", "oracle")

Predictors = Mapping[str, Predictor]  # by name
KEPT = ["set", "recording", "ball", "predictor", "protocol", "horizons_ms", "repeat", "hit",
        "returned"]  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """A setting of the mechanism.

    Attributes:
        every_ms: from one forecast to the next; None: all is forecast from the first window.
        latency_ms: from an action to the arm.
        label_error: standard deviation of the error of a component of the spin, the same in all
            labels of a ball, as a share of the spin.
    """

    every_ms: int | None
    latency_ms: int
    label_error: float

    @property
    def columns(self) -> dict[str, str | float]:
        """The setting in tables."""
        every = "first window" if self.every_ms is None else str(self.every_ms)
        return {"every_ms": every, "latency_ms": self.latency_ms, "label_error": self.label_error}

    def forecaster(self, name: str, predictor: Predictor) -> Forecaster:
        """Return a predictor as a forecaster that forecasts as often."""
        if self.every_ms is None:
            return Forecaster(name, predictor, ONCE)
        return Forecaster(name, predictor, EVERY_STEPS, steps=self.every_ms // STEP_MS)


SETTINGS = [Setting(*one) for one in product(INTERVALS_MS, LATENCIES_MS, LABEL_ERRORS)]


def reading_trials(
    shots: ReplaySet, predictors: Predictors, policies: Policies, seed: int
) -> list[ReplayTrial]:
    """Return the trials of a set with all predictors under both readings of Table I."""
    forecasters = [
        Forecaster(*named, mode) for mode in (ONCE, EVERY_STEP) for named in predictors.items()
    ]
    return replay_trials(shots, forecasters, policies, seed)


def mechanism_trials(
    shots: ReplaySet, predictors: Predictors, policies: Policies, seed: int
) -> Iterator[tuple[Setting, ReplayTrial]]:
    """Yield the trials of a set in all settings of the mechanism.

    Labels have the same errors in all trials of a set.
    """
    for setting in SETTINGS:
        forecasters = [setting.forecaster(name, predictors[name]) for name in OF_MECHANISM]
        for trial in replay_trials(shots, forecasters, policies, seed):
            random = np.random.default_rng([seed, *b"labels", *shots.name.encode()])
            histories = with_label_error(trial.histories, setting.label_error, random)
            yield setting, replace(trial, histories=histories, latency=setting.latency_ms / 1000)


def played(trial: ReplayTrial, columns: Mapping[str, str | float]) -> pd.DataFrame:
    """Run a trial; return its outcomes, with what the policy observes."""
    table = trial.run().table
    observed = [trained.observation for _, trained in trial.policies]
    table["observation"] = np.repeat(observed, len(trial.shots))
    return table[[*KEPT, "observation"]].assign(**columns)
