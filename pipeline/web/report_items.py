"""What a report shows: figures, animations and tables, each with its title and caption.

The modules of ``pipeline.report`` build them from what stages keep, so that a caption stays with
what it describes, and no stage depends on captions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from rallygap.pipeline.io.artifacts import replacing, write_csv
from rallygap.pipeline.web.figure_style import save_figure

FRAME_MS, LAST_FRAME_MS = 40, 1000  # how long an animation shows each frame, and its last


@dataclass(frozen=True)
class ReportFigure:
    """A figure, written as ``figures/<name>.png``."""

    figure: Figure
    name: str
    title: str
    caption: str

    kind = "figure"

    @property
    def file(self) -> str:
        """The path below the folder of the report."""
        return f"figures/{self.name}.png"

    def write(self, path: Path) -> None:
        """Draw the figure into a file."""
        save_figure(path, self.figure)


@dataclass(frozen=True)
class ReportAnimation:
    """Frames (H, W, 3) RGB at 25 Hz, repeated, written as ``figures/<name>.png``.

    An animated PNG keeps every pixel, and a viewer that cannot play it shows the first frame.
    """

    frames: Sequence[NDArray[np.uint8]]
    name: str
    title: str
    caption: str

    kind = "animation"

    @property
    def file(self) -> str:
        """The path below the folder of the report."""
        return f"figures/{self.name}.png"

    def write(self, path: Path) -> None:
        """Write the frames into a file."""
        first, *others = [Image.fromarray(frame) for frame in self.frames]
        durations = [*[FRAME_MS] * len(others), LAST_FRAME_MS]
        with replacing(path) as temporary:
            first.save(temporary, save_all=True, append_images=others, duration=durations, loop=0)


@dataclass(frozen=True)
class ReportTable:
    """A table, written as ``<name>.csv`` with six significant digits."""

    table: pd.DataFrame
    name: str
    title: str
    caption: str

    kind = "table"

    @property
    def file(self) -> str:
        """The path below the folder of the report."""
        return f"{self.name}.csv"

    def write(self, path: Path) -> None:
        """Write the table into a file."""
        write_csv(path, self.table)


ReportItem = ReportFigure | ReportAnimation | ReportTable


class Written(NamedTuple):
    """A report item that is in its file."""

    kind: str
    file: str
    title: str
    caption: str
