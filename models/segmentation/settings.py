"""The few numbers that decide where a recording is cut."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class SegmentSettings(BaseModel):
    """How recordings are cut into flights and episodes.

    Costs are in nats (log-likelihood), relative to a sample exactly where it is predicted.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    noise: Annotated[float, Field(ge=1e-4, le=0.05)] = 0.003
    """Standard deviation (m) of a coordinate, errors that change slowly along a path included."""
    longest_gap: Annotated[float, Field(gt=0, le=1)] = 0.1
    """Time (s) without samples after which an episode ends: too much may have happened in it."""
    contact_cost: Annotated[float, Field(ge=1, le=100)] = 16.0
    """What one more arc must explain before it is believed; more finds fewer contacts."""
    outlier_cost: Annotated[float, Field(ge=1, le=100)] = 16.0
    """What calling a sample an outlier costs; 16 is a gate of 5.7 standard deviations."""
    smallest_jump: Annotated[float, Field(ge=0, le=20)] = 1.5
    """Change of velocity (m/s) that makes a break a contact; less is a step of the measurement."""
    unbroken_ratio: Annotated[float, Field(ge=1, le=10)] = 1.5
    """An episode is unbroken while its residual is below this many times what noise leaves."""

    @property
    def unbroken_residual(self) -> float:
        """Residual (m, a distance in space) below which an episode counts as unbroken."""
        return self.unbroken_ratio * 3**0.5 * self.noise
