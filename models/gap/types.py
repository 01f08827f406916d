"""Types that the gap workflow shares: arrays (besides models/ball/types.py) and phases."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]

Places = tuple[int, ...]  # columns of a set of hypotheses, by their numbers

# Where a gap arises: in free flight, at the table, or in the measurement.
Phase = Literal["flight", "table", "sensor"]
PHASES: tuple[Phase, ...] = ("flight", "table", "sensor")
