"""The transformation from a source's axes into the table frame."""

from typing import Annotated, Self

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict, Field, model_validator

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS

Number = Annotated[float, Field(allow_inf_nan=False)]
Vector = tuple[Number, Number, Number]

ROTATION_TOLERANCE = 1e-4  # a matrix written with five digits passes, one that scales does not


class Frame(BaseModel):
    """The rigid motion from a source's axes to the table frame: ``p_table = rotation p + offset``.

    Attributes:
        rotation: (3, 3) proper rotation. Its rows are the table's x, y and z axes in the source's
            coordinates.
        offset: (3,) where the source's origin lies in the table frame (m).
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    rotation: tuple[Vector, Vector, Vector] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    offset: Vector = (0, 0, 0)

    @model_validator(mode="after")
    def _is_rigid(self) -> Self:
        rotation = np.array(self.rotation)
        if not np.allclose(rotation @ rotation.T, np.eye(3), atol=ROTATION_TOLERANCE):
            raise ValueError("rotation: rows must be unit vectors at right angles, five digits")
        if np.linalg.det(rotation) < 0:
            raise ValueError("rotation mirrors the axes; a mirrored ball spins the wrong way")
        return self

    def to_table(self, rows: pd.DataFrame) -> pd.DataFrame:
        """Return ``rows`` with positions moved, velocities and spins turned, where it has any."""
        rotation = np.array(self.rotation, dtype=float)
        moved = rows.copy()
        for columns in (POSITION_COLUMNS, VELOCITY_COLUMNS, SPIN_COLUMNS):
            if columns[0] in rows:
                moved[columns] = rows[columns].to_numpy(dtype=float) @ rotation.T
        moved[POSITION_COLUMNS] += self.offset
        return moved
