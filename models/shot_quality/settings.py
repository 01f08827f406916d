"""Settings of the forest that estimates winning probabilities."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class ForestSettings(BaseModel):
    """A random forest."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    trees: Annotated[int, Field(ge=1, le=10_000)]
    min_samples_leaf: Annotated[int, Field(ge=1, le=10_000)]
    """Training shots in a leaf, at least."""
