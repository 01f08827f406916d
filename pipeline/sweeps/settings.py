"""The settings of a sweep, ``experiments/profiles/sweeps/NAME.yaml``, checked with params.yaml.

Parameters are named as in ``dvc exp run -S``: by their dotted path in params.yaml.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, TypeAdapter, ValidationError, model_validator

from rallygap.models.policy.settings import HorizonsMs
from rallygap.pipeline.io.metrics import place, rounded
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
from rallygap.pipeline.profiles import merged
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


class Sweep:
    """A sweep: the settings in its file, and the content of params.yaml, which it changes.

    Its report has a folder, and ``scratch`` has the study's file and checkpoints.

    Raises:
        InputError: there is no such file, or its content is invalid.
    """

    def __init__(self, root: Path, name: str) -> None:
        self.root, self.name = root, name
        self.path = root / "experiments" / "profiles" / "sweeps" / f"{name}.yaml"
        self.report = root / "reports" / "sweeps" / name
        self.scratch = root / "scratch" / "sweeps" / name
        if not self.path.is_file():
            names = sorted(file.stem for file in self.path.parent.glob("*.yaml"))
            raise InputError(self.path, f"there is no such sweep; there are: {', '.join(names)}")
        content = as_json(read_yaml(self.path), self.path)
        try:
            self.settings = SETTINGS.validate_json(content, strict=True)
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(str(part) for part in first["loc"])
            raise InputError(self.path, first["msg"], field=field) from None
        load_params(root / "params.yaml")
        self.params: dict[str, Any] = read_yaml(root / "params.yaml")
        self._check()

    def _check(self) -> None:
        """Refuse unknown parameters, those of other stages, and values that are out of bounds."""
        settings = self.settings
        for key in (*settings.searchable, *settings.in_trials, *settings.space):
            self._in_params(key)
        if isinstance(settings, PolicySweep):
            load_simulator(settings.simulator)
        for key, values in settings.space.items():
            groups = tuple(f"{group}." for group in settings.searchable)
            if key in DEFINES_SCORE or not key.startswith(groups):
                searchable = " and ".join(settings.searchable)
                problem = f"cannot be searched; search parameters of {searchable}"
                raise InputError(self.path, problem, field=key)
            for value in values if isinstance(values, list) else (values.low, values.high):
                self.trial_params({key: value})

    def _in_params(self, key: str) -> Any:
        """Return the value of a dotted name in params.yaml."""
        value: Any = self.params
        for part in key.split("."):
            if not isinstance(value, dict) or part not in value:
                raise InputError(self.path, "is no parameter in params.yaml", field=key)
            value = value[part]
        return value

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
        defaults = {}
        for key, values in self.settings.space.items():
            value = defaults[key] = self._in_params(key)
            if isinstance(values, list):
                contained = value in values
            else:
                contained = isinstance(value, int | float) and values.low <= value <= values.high
            if not contained:
                return None
        return defaults

    def suggest(self, trial: "BaseTrial") -> dict[str, Value]:
        """Return the values of the searched parameters in a trial."""
        suggested: dict[str, Value] = {}
        for name, values in self.settings.space.items():
            if isinstance(values, list):
                suggested[name] = trial.suggest_categorical(name, values)
            elif isinstance(values.low, int) and isinstance(values.high, int):
                suggested[name] = trial.suggest_int(name, values.low, values.high, log=values.log)
            else:
                value = trial.suggest_float(name, values.low, values.high, log=values.log)
                suggested[name] = rounded(value, DIGITS)
        return suggested

    def trial_params(self, values: dict[str, Value]) -> Params:
        """Return the parameters of a trial.

        Raises:
            InputError: the values are invalid together.
        """
        shortened = merged(self.params, nested(self.settings.in_trials))
        return check_params(merged(shortened, nested(values)), self.path)


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Return dotted names as nested groups, like those of params.yaml."""
    groups: dict[str, Any] = {}
    for key, value in values.items():
        *above, last = key.split(".")
        place(groups, above)[last] = value
    return groups
