"""Settings of observations, goals, learning and sensor noise."""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.predictors.protocol import FUTURE, TICK

ObservationKind = Literal["intercept", "strict", "spread"]
"""``strict``: robot, forecasts and goal, as in the paper. ``intercept``: also when and where the
forecast ball crosses the racket's plane, extrapolated without drag. ``spread``: also the standard
deviations of the forecast positions."""

ForecastKind = Literal["exact", "exact_after_window", "filtered"]
"""What policies train on. ``exact``: the true future, from the launch on. ``exact_after_window``:
the same from when a filter has its first window. ``filtered``: what a filter makes of noisy
measurements, with its standard deviations."""


def _increasing(horizons: tuple[int, int, int]) -> tuple[int, int, int]:
    if not horizons[0] < horizons[1] < horizons[2]:
        raise ValueError(f"horizons must increase; {horizons} do not")
    return horizons


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"give the smaller limit first, not {limits}")
    return limits


_PREDICTED = round(1000 * TICK)
_Horizon = Annotated[int, Field(gt=0, le=_PREDICTED * FUTURE, multiple_of=_PREDICTED)]
HorizonsMs = Annotated[tuple[_Horizon, _Horizon, _Horizon], AfterValidator(_increasing)]
"""Forecast horizons (ms), on the grid of the predictors and within their range."""

_Range = AfterValidator(_ordered)
_Across = Annotated[float, Field(ge=-TABLE_HALF_WIDTH, le=TABLE_HALF_WIDTH)]
_Along = Annotated[float, Field(ge=0, le=TABLE_HALF_LENGTH)]
_Speed = Annotated[float, Field(gt=0, le=30)]
_Topspin = Annotated[float, Field(ge=-1000, le=1000)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class GoalSettings(_Settings):
    """Goals of returns: each quantity is drawn uniformly between its two limits."""

    landing_across: Annotated[tuple[_Across, _Across], _Range]
    """Where the return lands across the table (m)."""
    landing_along: Annotated[tuple[_Along, _Along], _Range]
    """How far behind the net it lands (m)."""
    speed: Annotated[tuple[_Speed, _Speed], _Range] | None
    """Of the ball just after the racket (m/s); null for no speed goal."""
    topspin: Annotated[tuple[_Topspin, _Topspin], _Range] | None
    """Of the ball just after the racket (rad/s), negative is backspin; null for no topspin
    goal."""

    @property
    def count(self) -> int:
        """Size of a goal."""
        return 2 + (self.speed is not None) + (self.topspin is not None)


class LearningSettings(_Settings):
    """Soft actor-critic (Haarnoja 2018), in training iterations with a checkpoint after each."""

    iterations: Annotated[int, Field(ge=1, le=10_000)]
    """Training iterations. Each starts with new balls from the checkpoint of the one before."""
    steps_per_iteration: Annotated[int, Field(ge=1, le=10_000_000)]
    """Control steps, all environments together."""
    environments: Annotated[int, Field(ge=1, le=1024)]
    """Parallel environments."""
    gradient_steps: Annotated[int, Field(ge=1, le=1000)]
    """After every control step of all environments."""
    warm_up: Annotated[int, Field(ge=0)]
    """Control steps before the first gradient step, in which rackets follow the balls."""
    batch: Annotated[int, Field(ge=1, le=65_536)]
    """Transitions per gradient step."""
    width: Annotated[int, Field(ge=4, le=4096)]
    """Of the two hidden layers of actor and critics."""
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Of the first iteration."""
    final_learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Of the last iteration; in between it decays geometrically."""
    discount: Annotated[float, Field(gt=0, lt=1)]
    """Per control step."""
    target_step: Annotated[float, Field(gt=0, le=1)]
    """Soft update coefficient (tau) of the target critics, per gradient step."""
    entropy: Annotated[float, Field(gt=0, le=10)]
    """Initial weight of the entropy, which is then tuned automatically."""

    @model_validator(mode="after")
    def _check_warm_up(self) -> "LearningSettings":
        if self.warm_up >= self.steps_per_iteration:
            problem = f"warm_up {self.warm_up} must be below {self.steps_per_iteration}"
            raise ValueError(f"{problem}, the steps_per_iteration")
        return self


class SensorNoise(_Settings):
    """Standard deviations of the measurement noise."""

    position: Annotated[float, Field(ge=0, le=0.05)]
    """Of a coordinate (m)."""
    spin: Annotated[float, Field(ge=0, le=0.5)]
    """Of a spin component, as a share of the spin's magnitude."""
