"""Settings of the forest that tells how often shots win."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class ForestSettings(BaseModel):
    """A random forest."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    trees: Annotated[int, Field(ge=1, le=10_000)]
    smallest_leaf: Annotated[int, Field(ge=1, le=10_000)]
    """Shots that a leaf has at least; its probability is their share of won points."""
