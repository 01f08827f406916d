"""Settings of segmentation, splits and scoring."""

from typing import Annotated

from pydantic import BaseModel, Field

Episodes = Annotated[int, Field(ge=0, le=1_000_000)]
Share = Annotated[float, Field(gt=0, lt=1)]


class ReplaySettings(BaseModel, extra="forbid", frozen=True):
    """Number of shots towards the robot that are reserved for replaying them to it."""

    stroke_pro: Episodes = 200
    """Strokes of professionals."""
    stroke_uni: Episodes = 200
    """Strokes of club players and semi-professionals."""
    receive: Episodes = 100
    """Serves of all these."""


class SplitSettings(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False):
    """How recordings are assigned to training, validation, test and replay."""

    test_episodes: Episodes = 500
    """Shots for testing, of each source that has enough, its groups in proportion."""
    replay: ReplaySettings = ReplaySettings()
    """Shots for replaying."""
    largest_share: Share = 0.25
    """Share of a group's recordings that tests, and each set to replay, take at most."""
    validation_share: Share = 0.1
    """Share of the remaining recordings for validation; the rest is for training."""


class SegmentSettings(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False):
    """How recordings are cut into flights and episodes.

    Costs are in nats (log-likelihood), relative to a sample exactly at its prediction.
    """

    noise: Annotated[float, Field(ge=1e-4, le=0.05)] = 0.003
    """Standard deviation (m) of a coordinate, slowly varying errors along a path included."""
    longest_gap: Annotated[float, Field(gt=0, le=1)] = 0.1
    """Time (s) without samples after which an episode ends: a contact may be missed in it."""
    contact_cost: Annotated[float, Field(ge=1, le=100)] = 16.0
    """Cost of one more arc; a higher cost finds fewer contacts."""
    outlier_cost: Annotated[float, Field(ge=1, le=100)] = 16.0
    """Cost of an outlier; 16 is a gate of 5.7 standard deviations."""
    smallest_jump: Annotated[float, Field(ge=0, le=20)] = 1.5
    """Change of velocity (m/s) above which a break is a contact; below it is a measurement step."""
    unbroken_ratio: Annotated[float, Field(ge=1, le=10)] = 1.5
    """An episode is unbroken while its residual is below this multiple of the noise level."""
    split: SplitSettings = SplitSettings()
    """How recordings are assigned to training, validation, test and replay."""

    @property
    def unbroken_residual(self) -> float:
        """Residual (m, a distance in space) below which an episode counts as unbroken."""
        return self.unbroken_ratio * 3**0.5 * self.noise


class ScoringSettings(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False):
    """When a contact counts as detected, and when as observable."""

    tolerance: Annotated[float, Field(gt=0, le=0.1)] = 0.005
    """Maximum time (s) between a true contact and the detected one."""
    reach: Annotated[float, Field(gt=0, le=1)] = 0.025
    """Time (s) on each side of an observable contact that must hold ..."""
    fewest_samples: Annotated[int, Field(ge=1, le=100)] = 3
    """... this many samples, with no other contact between."""
