"""Settings of the arena: physics, size of a session and camera errors."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from rallygap.models.ball.simulator import SimulatorError
from rallygap.models.ball.simulators import shipped


def _shipped(name: str) -> str:
    try:
        shipped(name)
    except SimulatorError as error:
        raise ValueError(str(error)) from None
    return name


Share = Annotated[float, Field(ge=0, le=0.5)]


class ArenaSettings(BaseModel):
    """Physics, size of a session and camera errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    physics: Annotated[str, AfterValidator(_shipped)] | None
    """A shipped simulator that flies the balls; null for physics that the seed draws."""
    game_episodes: Annotated[int, Field(ge=0)]
    """Smallest number of strokes in games; recordings are kept whole."""
    cannon_shots: Annotated[int, Field(ge=0)]
    """Shots of the ball cannon."""
    rate_hz: Annotated[float, Field(ge=50, le=1000)]
    """Frames a second."""
    position_noise: Annotated[float, Field(ge=0, le=0.05)]
    """Standard deviation of a coordinate (m), its slowly changing part included."""
    spin_noise: Share
    """Standard deviation of a spin component, as a share of the spin."""
    dropouts: Share
    """Share of the frames without a detection."""
    outliers: Share
    """Share of the frames with a false detection."""
