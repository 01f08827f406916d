"""What the numbers of a user's files mean: the axis of each column, and its unit."""

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from pydantic import AfterValidator, BaseModel

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS

Axis = Literal["x", "y", "z"]
PositionUnit = Literal["m", "cm", "mm"]
TimeUnit = Literal["s", "ms", "us", "ns"]
SpinUnit = Literal["rad/s", "rpm", "rev/s", "deg/s", "-rad/s", "-rpm", "-rev/s", "-deg/s"]

# How many of a unit are one SI unit. Division by a power of ten rounds correctly.
POSITION_UNITS: Mapping[str, float] = {"m": 1.0, "cm": 100.0, "mm": 1000.0}
TIME_UNITS: Mapping[str, float] = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
SPIN_UNITS: Mapping[str, float] = {
    "rad/s": 1.0,
    "rpm": 30 / np.pi,
    "rev/s": 0.5 / np.pi,
    "deg/s": 180 / np.pi,
    "-rad/s": -1.0,
    "-rpm": -30 / np.pi,
    "-rev/s": -0.5 / np.pi,
    "-deg/s": -180 / np.pi,
}


def _are_three(axes: tuple[Axis, Axis, Axis]) -> tuple[Axis, Axis, Axis]:
    if len(set(axes)) < 3:
        raise ValueError("must have x, y and z, each once")
    return axes


Axes = Annotated[tuple[Axis, Axis, Axis], AfterValidator(_are_three)]


class Units(BaseModel, extra="forbid", frozen=True):
    """Units of the columns; a minus means that spins have the opposite sense of rotation."""

    position: PositionUnit = "m"
    time: TimeUnit = "s"
    spin: SpinUnit = "rad/s"


class Conversion(BaseModel, extra="forbid", frozen=True):
    """What columns mean.

    Attributes:
        axes: that the columns x, y and z have, and wx, wy and wz likewise.
        units: of all columns.
    """

    axes: Axes = ("x", "y", "z")
    units: Units = Units()

    def to_si(self, rows: pd.DataFrame) -> pd.DataFrame:
        """Return rows in the columns of a ``RawTable``: s, m and, where there are spins, rad/s.

        Args:
            rows: columns t, x, y, z, and wx, wy, wz where there are spins, as users name them.
        """
        columns: dict[str, str] = {}
        for name, axis in zip("xyz", self.axes, strict=True):
            columns |= {name: f"p{axis}", f"w{name}": f"w{axis}"}
        units, converted = self.units, rows.rename(columns=columns)
        converted["t"] /= TIME_UNITS[units.time]
        converted[POSITION_COLUMNS] /= POSITION_UNITS[units.position]
        if SPIN_COLUMNS[0] in converted:
            converted[SPIN_COLUMNS] /= SPIN_UNITS[units.spin]
        return converted
