"""Types of arrays beside those of numbers (models/ball/types.py)."""

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
