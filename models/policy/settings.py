"""The settings of what a policy sees and is asked for."""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from models.predictors.protocol import FUTURE, TICK

ObservationKind = Literal["intercept", "strict"]
"""``strict``: robot, forecasts and goal, as in the paper. ``intercept``: also where and when the
forecast ball, flying on without drag, crosses the racket's plane."""


def _growing(horizons: tuple[int, int, int]) -> tuple[int, int, int]:
    if not horizons[0] < horizons[1] < horizons[2]:
        raise ValueError(f"horizons must grow, which {horizons} do not")
    return horizons


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"give the smaller limit first, not {limits}")
    return limits


_PREDICTED = round(1000 * TICK)
_Horizon = Annotated[int, Field(gt=0, le=_PREDICTED * FUTURE, multiple_of=_PREDICTED)]
HorizonsMs = Annotated[tuple[_Horizon, _Horizon, _Horizon], AfterValidator(_growing)]
"""How far ahead (ms) the policy sees the ball: on the grid of the predictors, no further."""

_Range = AfterValidator(_ordered)
_Across = Annotated[float, Field(ge=-TABLE_HALF_WIDTH, le=TABLE_HALF_WIDTH)]
_Along = Annotated[float, Field(ge=0, le=TABLE_HALF_LENGTH)]
_Speed = Annotated[float, Field(gt=0, le=30)]
_Topspin = Annotated[float, Field(ge=-1000, le=1000)]


class GoalSettings(BaseModel):
    """What a return is asked to do: each quantity is drawn evenly between its two limits."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    landing_across: Annotated[tuple[_Across, _Across], _Range]
    """Where the return lands across the table (m)."""
    landing_along: Annotated[tuple[_Along, _Along], _Range]
    """How far behind the net it lands (m)."""
    speed: Annotated[tuple[_Speed, _Speed], _Range] | None
    """Of the ball just after the racket (m/s); null where no speed is asked for."""
    topspin: Annotated[tuple[_Topspin, _Topspin], _Range] | None
    """Of the ball just after the racket (rad/s), negative is backspin; null where none is asked
    for."""

    @property
    def count(self) -> int:
        """How many numbers a goal has."""
        return 2 + (self.speed is not None) + (self.topspin is not None)


class LearningSettings(BaseModel):
    """How a policy learns: soft actor-critic (Haarnoja 2018), in legs that it can resume at."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    legs: Annotated[int, Field(ge=1, le=10_000)]
    """Parts of the training. Each begins with new balls from a checkpoint of the one before."""
    ticks: Annotated[int, Field(ge=1, le=10_000_000)]
    """Of a leg: control ticks of all arms together."""
    arms: Annotated[int, Field(ge=1, le=1024)]
    """That play at once."""
    gradient_steps: Annotated[int, Field(ge=1, le=1000)]
    """After every tick of all arms."""
    warm_up: Annotated[int, Field(ge=0)]
    """Ticks of random actions before the first gradient step, all within the first leg."""
    batch: Annotated[int, Field(ge=1, le=65_536)]
    """Transitions a gradient step."""
    width: Annotated[int, Field(ge=4, le=4096)]
    """Of the two hidden layers of actor and critics."""
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Of the first leg."""
    final_learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Of the last leg; in between it falls by the same factor from leg to leg."""
    discount: Annotated[float, Field(gt=0, lt=1)]
    """Of a tick."""
    target_step: Annotated[float, Field(gt=0, le=1)]
    """Share of the way to the critics that their targets go in a gradient step."""
    entropy: Annotated[float, Field(gt=0, le=10)]
    """First weight of the entropy, which is then tuned automatically."""

    @model_validator(mode="after")
    def _warm_up_in_first_leg(self) -> "LearningSettings":
        if self.warm_up >= self.ticks:
            raise ValueError(f"a warm-up of {self.warm_up} ticks does not end within {self.ticks}")
        return self


class SensorNoise(BaseModel):
    """What cameras add to the true ball, anew in every measurement: standard deviations."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    position: Annotated[float, Field(ge=0, le=0.05)]
    """Of a coordinate (m)."""
    spin: Annotated[float, Field(ge=0, le=0.5)]
    """Of a spin component, as a share of the spin's size."""
