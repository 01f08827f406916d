"""The settings of a sweep, ``experiments/profiles/sweeps/NAME.yaml``, checked with params.yaml.

Parameters are named as in ``dvc exp run -S``: by their dotted path in params.yaml.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, TypeAdapter, ValidationError, model_validator

from rallygap.models.policy.settings import HorizonsMs
from rallygap.pipeline.experiments.profiles import merged
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import (
    Name,
    Params,
    Settings,
    as_json,
    check_params,
    load_params,
    read_yaml,
)
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance, short

if TYPE_CHECKING:
    from optuna.trial import BaseTrial

Value = bool | int | float | str | None

Report = Callable[[int, float], None]
"""Takes the score after each epoch or iteration, counted from 1; raises ``TrialPruned``."""

Train = Callable[[Params, Path, Report], float]
"""Trains with parameters in a folder for checkpoints, and returns the final score."""

DIGITS = 3  # significant digits of a suggested number
# Also hides the spin of validation windows, so that losses of different shares do not compare.
DEFINES_SCORE = {"train_predictor.training.hidden_spin"}


class Range(Settings):
    """Numbers between two limits, integers if both limits are."""

    low: int | float
    high: int | float
    log: bool = False
    """Sample the logarithm uniformly."""

    @model_validator(mode="after")
    def _check(self) -> "Range":
        if not self.low < self.high or (self.log and self.low <= 0):
            raise ValueError("give a low limit, above zero with log, and a higher one")
        return self


Values = Annotated[
    Annotated[Range, Tag("range")] | Annotated[list[Value], Field(min_length=2), Tag("choices")],
    Discriminator(lambda values: "choices" if isinstance(values, list) else "range"),
]
"""Of a searched parameter: a range, or the choices."""


def suggested(trial: "BaseTrial", name: str, values: Values) -> Value:
    """Return the value of a parameter that a trial uses."""
    if isinstance(values, list):
        choice: Value = trial.suggest_categorical(name, values)
        return choice
    low, high = values.low, values.high
    if isinstance(low, int) and isinstance(high, int):
        return trial.suggest_int(name, low, high, log=values.log)
    return float(f"{trial.suggest_float(name, low, high, log=values.log):.{DIGITS}g}")


def _contains(values: Values, value: Any) -> bool:
    if isinstance(values, list):
        return value in values
    return isinstance(value, int | float) and values.low <= value <= values.high


class PruningSettings(Settings):
    """When a trial that is worse than the median of the others is pruned."""

    first_trials: Annotated[int, Field(ge=1, le=1000)]
    """Trials of which none is pruned."""
    first_steps: Annotated[int, Field(ge=0, le=1000)]
    """Epochs or training iterations after which no trial is pruned."""


class SweepSettings(Settings):
    """Settings of sweeps of both kinds."""

    trials: Annotated[int, Field(ge=1, le=100_000)]
    """Default number of trials."""
    in_trials: dict[str, Value]
    """Parameters that make trials shorter than full trainings; not part of the result."""
    space: Annotated[dict[str, Values], Field(min_length=1)]
    """Parameters to search."""
    pruning: PruningSettings


class PredictorSweep(SweepSettings):
    """Searches the architecture and training of a network of ``train_predictor``."""

    stage: ClassVar[str] = "train_predictor"
    direction: ClassVar[Literal["minimize", "maximize"]] = "minimize"
    score: ClassVar[str] = "validation loss"
    step: ClassVar[str] = "epoch"

    trains: Literal["predictor"]
    network: Name
    """A key of ``train_predictor.networks``."""

    @property
    def searchable(self) -> tuple[str, ...]:
        """Groups of params.yaml whose parameters may be searched."""
        return ("train_predictor.training", f"train_predictor.networks.{self.network}")


class PolicySweep(SweepSettings):
    """Searches the training of a group of ``train_policy``, for one simulator and its horizons."""

    stage: ClassVar[str] = "train_policy"
    direction: ClassVar[Literal["minimize", "maximize"]] = "maximize"
    score: ClassVar[str] = "return rate"
    step: ClassVar[str] = "iteration"

    trains: Literal["policy"]
    group: Name
    """A key of ``train_policy.groups``."""
    simulator: Name
    """A shipped simulator."""
    horizons_ms: HorizonsMs

    @property
    def searchable(self) -> tuple[str, ...]:
        """Groups of params.yaml whose parameters may be searched."""
        return (f"train_policy.groups.{self.group}.learning", "train_policy.reward")


SETTINGS: TypeAdapter[PredictorSweep | PolicySweep] = TypeAdapter(
    Annotated[PredictorSweep | PolicySweep, Field(discriminator="trains")]
)


@dataclass(frozen=True)
class Sweep:
    """A sweep: its settings and the parameters that it changes.

    Attributes:
        root: the repository.
        name: of the file ``experiments/profiles/sweeps/NAME.yaml``.
        settings: its content.
        params: the content of params.yaml.
    """

    root: Path
    name: str
    settings: PredictorSweep | PolicySweep
    params: dict[str, Any]

    @property
    def path(self) -> Path:
        """The file of the settings."""
        return _path(self.root, self.name)

    @property
    def report(self) -> Path:
        """The folder of the results."""
        return self.root / "reports" / "sweeps" / self.name

    @property
    def scratch(self) -> Path:
        """The folder of the study's file and of checkpoints."""
        return self.root / "scratch" / "sweeps" / self.name

    @property
    def study(self) -> str:
        """The name of the study: the sweep and a digest of all that a trial depends on.

        It covers the search space, code, data and other parameters, but not the number of trials.

        Raises:
            InputError: the data are missing.
        """
        episodes = self.root / "artifacts" / "segment"
        if isinstance(self.settings, PredictorSweep) and not episodes.exists():
            problem = "is missing; `dvc repro segment` is enough for a sweep of predictors"
            raise InputError(episodes, problem)
        origin = provenance(self.root, self.settings.stage).fingerprint
        settings = self.settings.model_dump_json(exclude={"trials"})
        return f"{self.name}-{short(hashlib.sha256((origin + settings).encode()).hexdigest())}"

    def defaults(self) -> dict[str, Value] | None:
        """Return the searched parameters as in params.yaml; None if the space excludes them."""
        space = self.settings.space
        values = {key: lookup(self.params, key, self.path) for key in space}
        return values if all(_contains(space[key], values[key]) for key in space) else None

    def suggest(self, trial: "BaseTrial") -> dict[str, Value]:
        """Return the values of the searched parameters in a trial."""
        return {
            name: suggested(trial, name, values) for name, values in self.settings.space.items()
        }

    def trial_params(self, values: dict[str, Value]) -> Params:
        """Return the parameters of a trial.

        Raises:
            InputError: the values are invalid together.
        """
        shortened = merged(self.params, nested(self.settings.in_trials))
        return check_params(merged(shortened, nested(values)), self.path)


def _path(root: Path, name: str) -> Path:
    return root / "experiments" / "profiles" / "sweeps" / f"{name}.yaml"


def load_sweep(root: Path, name: str) -> Sweep:
    """Read the settings of a sweep and check them against params.yaml.

    Raises:
        InputError: there is no such file, or its content is invalid.
    """
    path = _path(root, name)
    if not path.is_file():
        names = sorted(file.stem for file in path.parent.glob("*.yaml"))
        raise InputError(path, f"there is no such sweep; there are: {', '.join(names)}")
    try:
        settings = SETTINGS.validate_json(as_json(read_yaml(path), path), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(path, first["msg"], field=field) from None
    load_params(root / "params.yaml")
    sweep = Sweep(root, name, settings, read_yaml(root / "params.yaml"))
    _check(sweep)
    return sweep


def _check(sweep: Sweep) -> None:
    """Refuse unknown parameters, parameters of other stages, and values that are out of bounds."""
    settings = sweep.settings
    for key in (*settings.searchable, *settings.in_trials, *settings.space):
        lookup(sweep.params, key, sweep.path)
    if isinstance(settings, PolicySweep):
        load_simulator(settings.simulator)
    for key, values in settings.space.items():
        if key in DEFINES_SCORE or not key.startswith(tuple(f"{g}." for g in settings.searchable)):
            searchable = " and ".join(settings.searchable)
            problem = f"cannot be searched; search parameters of {searchable}"
            raise InputError(sweep.path, problem, field=key)
        for value in values if isinstance(values, list) else (values.low, values.high):
            sweep.trial_params({key: value})


def lookup(params: dict[str, Any], key: str, path: Path) -> Any:
    """Return the value of a dotted name in params.yaml.

    Raises:
        InputError: there is none; ``path`` is the file that uses the name.
    """
    value: Any = params
    for part in key.split("."):
        if not isinstance(value, dict) or part not in value:
            raise InputError(path, "is no parameter in params.yaml", field=key)
        value = value[part]
    return value


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Return dotted names as nested groups, like those of params.yaml."""
    groups: dict[str, Any] = {}
    for key, value in values.items():
        *above, last = key.split(".")
        group = groups
        for part in above:
            group = group.setdefault(part, {})
        group[last] = value
    return groups
