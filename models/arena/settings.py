"""How much the arena records, and how well its cameras see."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Share = Annotated[float, Field(ge=0, le=0.5)]


class ArenaSettings(BaseModel):
    """A session of the arena."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    game_episodes: Annotated[int, Field(ge=0)]
    """Strokes in games, at least so many: a recording is never cut short."""
    cannon_shots: Annotated[int, Field(ge=0)]
    """Shots of the ball cannon."""
    rate_hz: Annotated[float, Field(ge=50, le=1000)]
    """Frames a second."""
    position_noise: Annotated[float, Field(ge=0, le=0.05)]
    """Standard deviation of a coordinate (m), its slowly changing part included."""
    spin_noise: Share
    """Standard deviation of a spin component, as a share of the spin."""
    dropouts: Share
    """Share of the frames in which the ball is missed."""
    outliers: Share
    """Share of the frames in which something else is taken for the ball."""
