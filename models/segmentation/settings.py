"""The few numbers that decide where a recording is cut, and which split it goes to."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Episodes = Annotated[int, Field(ge=0, le=1_000_000)]
Share = Annotated[float, Field(gt=0, lt=1)]


class ReplaySettings(BaseModel):
    """How many shots towards the robot are kept for replaying them to it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    stroke_pro: Episodes = 200
    """Strokes of professionals."""
    stroke_uni: Episodes = 200
    """Strokes of club players and semi-professionals."""
    receive: Episodes = 100
    """Serves of all these."""


class SplitSettings(BaseModel):
    """How recordings are shared out among training, validation, test and replay."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    test_episodes: Episodes = 500
    """Shots for testing, of each source that has enough, its groups in proportion."""
    replay: ReplaySettings = ReplaySettings()
    """Shots for replaying."""
    largest_share: Share = 0.25
    """Share of a group's recordings that tests, and each set to replay, take at most."""
    validation_share: Share = 0.1
    """Share of the recordings left by which a predictor is chosen; the rest trains it."""


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
    split: SplitSettings = SplitSettings()
    """How many recordings train, choose and test a predictor, or are replayed."""

    @property
    def unbroken_residual(self) -> float:
        """Residual (m, a distance in space) below which an episode counts as unbroken."""
        return self.unbroken_ratio * 3**0.5 * self.noise


class ScoringSettings(BaseModel):
    """When a contact counts as found, and when it can be expected to be."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    tolerance: Annotated[float, Field(gt=0, le=0.1)] = 0.005
    """Time (s) between a contact and what was found of it, at most."""
    reach: Annotated[float, Field(gt=0, le=1)] = 0.025
    """Time (s) on each side of a contact in which it must have been measured to be seen ..."""
    fewest_samples: Annotated[int, Field(ge=1, le=100)] = 3
    """... so often, in the flights that it ends and begins."""
