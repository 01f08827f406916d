"""A doubt about recordings, and the line of source.yaml that corrects them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.sources.conversion import Conversion, Units


@dataclass(frozen=True)
class Doubt:
    """What is doubtful about recordings.

    Attributes:
        text: a sentence about the recordings, without a full stop.
        impossible: whether it cannot be right, rather than being unusual.
        line: of source.yaml that corrects it, empty where none does.
    """

    text: str
    impossible: bool = False
    line: str = ""


@dataclass(frozen=True)
class Setup:
    """How a source transforms its rows: the lines of source.yaml as they are.

    Attributes:
        frame: transformation into the table frame.
        conversion: axes and units of the columns; ``None`` where no source.yaml states them.
    """

    frame: Frame
    conversion: Conversion | None

    @property
    def units(self) -> Units:
        """Units of the columns."""
        return self.conversion.units if self.conversion else Units()

    def units_line(self, **changes: str) -> str:
        """Return the line with changed units."""
        if self.conversion is None:
            return ""
        units = self.units.model_copy(update=changes).model_dump(exclude_defaults=True)
        return f"units: {{{', '.join(f'{name}: {unit}' for name, unit in units.items())}}}"

    def axes_line(self, order: Sequence[int]) -> str:
        """Return the line with which table axis ``i`` is the present axis ``order[i]``."""
        if self.conversion is None:
            return ""
        names = ["xyz"[list(order).index("xyz".index(axis))] for axis in self.conversion.axes]
        return f"axes: [{', '.join(names)}]"

    def frame_line(self, rotation: Floats, offset: Floats) -> str:
        """Return the line with a further rotation (3, 3) and then a further offset (3,), m."""
        if self.conversion is None:
            return ""
        whole = rotation @ np.array(self.frame.rotation)
        moved = rotation @ np.array(self.frame.offset) + offset
        parts = []
        if not (whole == np.eye(3)).all():
            parts.append(f"rotation: [{', '.join(map(_numbers, whole))}]")
        if moved.any():
            parts.append(f"offset: {_numbers(moved)}")
        return f"frame: {{{', '.join(parts)}}}"


def _numbers(values: Floats) -> str:
    return f"[{', '.join(f'{value + 0.0:.6g}' for value in values)}]"
