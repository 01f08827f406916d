"""Types of the gap workflow besides the arrays of numbers in ``models/ball/types.py``."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]

Places = tuple[int, ...]  # columns of a set of hypotheses, by their numbers

Phase = Literal["flight", "table", "sensor"]  # of a ball's way from its launch into the data
PHASES: tuple[Phase, ...] = ("flight", "table", "sensor")
