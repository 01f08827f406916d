"""What a sweep tries: ``profiles/sweeps/<name>.yaml``, typed, bounded, or refused by name.

Parameters are named as in ``dvc exp run -S``, by the dotted path through params.yaml.
"""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, TypeAdapter, model_validator

from models.policy.settings import HorizonsMs
from pipeline.params import Name, Settings

if TYPE_CHECKING:
    from optuna.trial import BaseTrial

Value = bool | int | float | str | None

DIGITS = 3  # of a suggested number: more could not be told apart


class Range(Settings):
    """Numbers between two limits; whole ones where both limits are whole."""

    low: int | float
    high: int | float
    log: bool = False
    """Whether factors count, not differences."""

    @model_validator(mode="after")
    def _has_room(self) -> "Range":
        if not self.low < self.high or (self.log and self.low <= 0):
            raise ValueError("give a low limit, above zero where log, and a higher one")
        return self

    def suggested(self, name: str, trial: "BaseTrial") -> Value:
        """Return the number that a trial tries, in few enough digits to be read."""
        if isinstance(self.low, int) and isinstance(self.high, int):
            return trial.suggest_int(name, self.low, self.high, log=self.log)
        return float(f"{trial.suggest_float(name, self.low, self.high, log=self.log):.{DIGITS}g}")

    def holds(self, value: Any) -> bool:
        """Return whether a value lies within the limits."""
        return isinstance(value, int | float) and self.low <= value <= self.high

    @property
    def extremes(self) -> list[Value]:
        """Values that params.yaml must take."""
        return [self.low, self.high]


class Choices(Settings):
    """Values of which a trial tries one."""

    choices: Annotated[list[Value], Field(min_length=2)]

    def suggested(self, name: str, trial: "BaseTrial") -> Value:
        """Return the value that a trial tries."""
        chosen: Value = trial.suggest_categorical(name, self.choices)
        return chosen

    def holds(self, value: Any) -> bool:
        """Return whether a value is among them."""
        return value in self.choices

    @property
    def extremes(self) -> list[Value]:
        """Values that params.yaml must take."""
        return self.choices


def _kind(content: Any) -> str:
    named = isinstance(content, dict) and "choices" in content
    return "choices" if named or isinstance(content, Choices) else "range"


Parameter = Annotated[
    Annotated[Range, Tag("range")] | Annotated[Choices, Tag("choices")], Discriminator(_kind)
]


class PruningSettings(Settings):
    """When trials that lag behind are given up: those worse than the median of the others."""

    first_trials: Annotated[int, Field(ge=1, le=1000)]
    """None of these is given up, ..."""
    first_steps: Annotated[int, Field(ge=0, le=1000)]
    """... and no other within so many epochs or legs."""


class SweepSettings(Settings):
    """What both kinds of sweeps have."""

    trials: Annotated[int, Field(ge=1, le=100_000)]
    """How many, unless the command line says otherwise."""
    in_trials: dict[str, Value]
    """Parameters that differ from params.yaml in trials alone, which have to be short."""
    space: Annotated[dict[str, Parameter], Field(min_length=1)]
    """The parameters to be found, each with the values to try."""
    pruning: PruningSettings


class PredictorSweep(SweepSettings):
    """Finds how a network of ``train_predictor`` is built and trained."""

    stage: ClassVar[str] = "train_predictor"
    direction: ClassVar[Literal["minimize", "maximize"]] = "minimize"
    score: ClassVar[str] = "validation loss"
    step: ClassVar[str] = "epoch"

    trains: Literal["predictor"]
    network: Name
    """Of ``train_predictor.networks``."""

    @property
    def places(self) -> tuple[str, ...]:
        """Where in params.yaml the parameters to be found may stand."""
        return ("train_predictor.training.", f"train_predictor.networks.{self.network}.")


class PolicySweep(SweepSettings):
    """Finds how a group of ``train_policy`` learns, on one simulator and one triple of horizons."""

    stage: ClassVar[str] = "train_policy"
    direction: ClassVar[Literal["minimize", "maximize"]] = "maximize"
    score: ClassVar[str] = "return rate"
    step: ClassVar[str] = "leg"

    trains: Literal["policy"]
    group: Name
    """Of ``train_policy.groups``."""
    simulator: Name
    """A shipped one."""
    horizons_ms: HorizonsMs

    @property
    def places(self) -> tuple[str, ...]:
        """Where in params.yaml the parameters to be found may stand."""
        return (f"train_policy.groups.{self.group}.learning.",)


SWEEPS: TypeAdapter[PredictorSweep | PolicySweep] = TypeAdapter(
    Annotated[PredictorSweep | PolicySweep, Field(discriminator="trains")]
)
