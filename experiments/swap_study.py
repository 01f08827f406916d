"""When swapping the predictor of a policy helps: protocols, ages of forecasts, latency, labels."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.policy.incoming_balls import CONTROL_STEP
from rallygap.models.predictors.protocol import Predictor
from rallygap.models.replay.replayed_balls import with_label_error
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.storage import described_policies
from rallygap.pipeline.policies.training import TrainingJob, TrainingResult, train_policies
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_sets import ReplaySet
from rallygap.pipeline.transfer.replay_trials import (
    Forecaster,
    Policies,
    ReplayTrial,
    replay_trials,
)
from rallygap.pipeline.transfer.retraining import ORIGINAL, RETRAINED, in_simulator
from rallygap.pipeline.transfer.returns import EVERY_STEP, ONCE

Predictors = Mapping[str, Predictor]  # by name

RETRAINED_KIND = "intercept"  # what the policies observe that are trained again
EXPERIMENTS = ("readings", "mechanism", "retrained")
PHYSICS = "physics_c"  # what others are compared with
OF_MECHANISM = (PHYSICS, "amended", "transformer", "oracle")
POLICY, MECHANISM = ["observation", "horizons_ms"], ["every_ms", "latency_ms", "label_error"]
KEPT = ["set", "recording", "ball", "predictor", "protocol", "horizons_ms", "repeat", "hit",
        "returned"]  # fmt: skip


def trained_policies(root: Path, params: Params, folder: Path) -> list[TrainingResult]:
    """Train the policies of the profile, and the same in the amended simulator."""
    described = list(described_policies(params.train_policy, params.seed))
    amended = amended_simulator(root, params)
    again = [
        in_simulator(policy, ARENA, amended)
        for policy in described
        if policy.observation == RETRAINED_KIND
    ]
    return train_policies(
        [TrainingJob(policy, folder / policy.name) for policy in (*described, *again)]
    )


def amended_simulator(root: Path, params: Params) -> Simulator:
    """Return the simulator of the policies as close_gap has amended it from shots of the arena.

    Raises:
        InputError: it has not.
    """
    nominal = params.sim2real.simulator
    simulator = amended_by(root / "artifacts" / "close_gap", ARENA, nominal)
    if simulator is None:
        problem = f"close_gap has not amended {nominal} from shots of the arena"
        raise InputError("params.yaml", problem, field="close_gap.name")
    return simulator


@dataclass(frozen=True)
class Setting:
    """A setting of the mechanism.

    Attributes:
        every_ms: from one forecast to the next; None: all is forecast from the first window.
        latency_ms: from an action to the arm, which takes a command every 20 ms.
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

    @property
    def mode(self) -> str | int:
        """When a ``Forecaster`` forecasts."""
        return ONCE if self.every_ms is None else self.every_ms // round(1000 * CONTROL_STEP)


SETTINGS = [
    Setting(every_ms, latency_ms, label_error)
    for every_ms in (40, 80, 160, 320, None)
    for latency_ms in (0, 40, 100, 200)
    for label_error in (0.0, 0.2)
]


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
        forecasters = [Forecaster(name, predictors[name], setting.mode) for name in OF_MECHANISM]
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


def study_tables(played: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return all tables by name, from the trials of each experiment."""
    readings, mechanism, retrained = (played[name] for name in EXPERIMENTS)
    alike = (readings["observation"] == RETRAINED_KIND) & (readings["protocol"] == EVERY_STEP)
    original = readings[alike].assign(policy=ORIGINAL)
    both = pd.concat([original, retrained.assign(policy=RETRAINED)])
    per_reading = [*POLICY, "predictor", "protocol"]
    shares = {
        "readings": (readings, ["set", *per_reading]),
        "readings_all": (readings, per_reading),
        "mechanism": (mechanism, [*POLICY, "predictor", *MECHANISM]),
        "retrained": (both, ["policy", "horizons_ms", "predictor"]),
    }
    physics = {"predictor": PHYSICS}
    gains = {
        "gains": (readings, [*POLICY, "protocol"], physics),
        "gains_by_set": (readings, ["set", *POLICY, "protocol"], physics),
        "gains_every_tick": (readings, [*POLICY, "predictor"], {"protocol": ONCE}),
        "gains_mechanism": (mechanism, [*POLICY, *MECHANISM], physics),
        "gains_retrained": (both, ["horizons_ms", "predictor"], {"policy": ORIGINAL}),
    }
    return {
        **{name: rates(*arguments) for name, arguments in shares.items()},
        **{name: differences(*arguments) for name, arguments in gains.items()},
    }
