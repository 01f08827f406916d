"""The policies that parameters ask for, and trained ones as files: weights, description."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, field_validator
from safetensors import SafetensorError
from safetensors.numpy import load, save

from rallygap.models.ball.simulator import Simulator
from rallygap.models.policy.batch_simulation import ACTIONS
from rallygap.models.policy.observation import observation_size
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.random_streams import training_seed
from rallygap.models.policy.settings import (
    DEFAULT_REWARD,
    ForecastKind,
    GoalSettings,
    HorizonsMs,
    LearningSettings,
    ObservationKind,
    RewardSettings,
)
from rallygap.models.policy.task import Task
from rallygap.pipeline.io.artifacts import read_as, replacing_folder, write_json
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import TrainPolicySettings
from rallygap.pipeline.runtime.errors import InputError

WEIGHTS, DESCRIPTION = "weights.safetensors", "policy.json"


class TrainedPolicy(BaseModel):
    """Description of a trained policy, stored with its weights.

    Attributes:
        group: of ``train_policy.groups`` in params.yaml.
        simulator: name of the simulator that it was trained in.
        effects: that simulator's effects and parameters.
        horizons: of its forecasts, ms.
        observation: its kind; scales are in ``models/policy/observation.py``.
        forecasts: that it was trained with.
        goals: their distribution in training.
        learning: how it was trained.
        seed: of its training.
        repeat: number of the policy among those that differ only in the seed.
        reward: weights of its parts; not written if they are the default ones.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    group: str
    simulator: str
    effects: dict[str, dict[str, Any]]
    horizons: HorizonsMs
    observation: ObservationKind
    goals: GoalSettings
    learning: LearningSettings
    seed: int
    repeat: int
    forecasts: ForecastKind = "exact"
    reward: RewardSettings = DEFAULT_REWARD

    @field_validator("effects")
    @classmethod
    def _check_effects(cls, effects: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
        Simulator.from_dict(effects)
        return effects

    @property
    def name(self) -> str:
        """Its folder's name: unique among trained policies."""
        return f"{self.group}-{self.simulator}-{self.horizons[0]}ms-{self.repeat}"

    @property
    def horizons_label(self) -> str:
        """Its first and last horizon, ms, as in reports: ``115-125``."""
        return f"{self.horizons[0]}-{self.horizons[-1]}"

    @property
    def labels(self) -> dict[str, str | int]:
        """Its key columns in tables."""
        return {
            "group": self.group,
            "simulator": self.simulator,
            "horizons_ms": self.horizons_label,
            "repeat": self.repeat,
        }

    @property
    def task(self) -> Task:
        """The task that it was trained for."""
        simulator = Simulator.from_dict(self.effects)
        return Task(
            simulator, self.horizons, self.goals, self.observation, self.forecasts, self.reward
        )


def described_policies(settings: TrainPolicySettings, seed: int) -> Iterator[TrainedPolicy]:
    """Yield the policies to train; a repeat has the same seed in all simulators and horizons."""
    for name, group in settings.groups.items():
        for simulator in group.simulators:
            for horizons in group.horizons_ms:
                for repeat in range(group.repeats):
                    own = training_seed(seed, repeat)
                    yield described_policy(settings, name, simulator, horizons, own, repeat)


def described_policy(
    settings: TrainPolicySettings,
    group: str,
    simulator: str,
    horizons: HorizonsMs,
    seed: int,
    repeat: int,
) -> TrainedPolicy:
    """Describe a policy of a group to train; arguments as in ``TrainedPolicy``."""
    shared = settings.groups[group]
    return TrainedPolicy(
        group=group,
        simulator=simulator,
        effects=load_simulator(simulator).to_dict(),
        horizons=horizons,
        observation=shared.observation,
        goals=shared.goals,
        learning=shared.learning,
        seed=seed,
        repeat=repeat,
        reward=settings.reward,
    )


def save_policy(folder: Path, policy: Policy, description: TrainedPolicy) -> None:
    """Write a trained policy; the same weights give the same bytes."""
    with replacing_folder(folder) as temporary:
        (temporary / WEIGHTS).write_bytes(save(policy.to_arrays()))
        default = {"reward"} if description.reward == DEFAULT_REWARD else set()
        write_json(temporary / DESCRIPTION, description.model_dump(mode="json", exclude=default))


def load_policy(folder: Path) -> tuple[Policy, TrainedPolicy]:
    """Read a trained policy and its description.

    Raises:
        InputError: a file is missing or broken.
    """
    description = read_as(folder / DESCRIPTION, TrainedPolicy, "train_policy")
    path = folder / WEIGHTS
    try:
        policy = Policy.from_arrays(load(path.read_bytes()))
    except FileNotFoundError:
        problem = "there is no such file; run the stage train_policy"
        raise InputError(path, problem) from None
    except (OSError, SafetensorError, ValueError, KeyError, TypeError) as error:
        raise InputError(path, f"is not a file of weights: {error}") from None
    goals, horizons = description.goals.count, len(description.horizons)
    inputs = observation_size(horizons, goals, description.observation)
    ends = policy.layers[0][0].shape[-1:], policy.layers[-1][1].shape
    if ends != ((inputs,), (ACTIONS,)):
        problem = f"does not fit {DESCRIPTION}: give {inputs} inputs, {ACTIONS} outputs"
        raise InputError(path, problem)
    if not all(np.isfinite(part).all() for layer in policy.layers for part in layer):
        raise InputError(path, "has values that are not finite; train the policy again")
    return policy, description


def load_policies(folder: Path, group: str) -> list[tuple[Policy, TrainedPolicy]]:
    """Read all trained policies of a group, by name.

    Raises:
        InputError: there is none, or a file is broken.
    """
    paths = sorted(folder.glob(f"{group}-*/{DESCRIPTION}"))
    if not paths:
        problem = f"has no policy of the group {group}; see train_policy.groups in params.yaml"
        raise InputError(folder, problem)
    return [load_policy(path.parent) for path in paths]
