"""Types of the compiled functions: tuples, which stay in registers, and numpy arrays."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]

Vector = tuple[float, float, float]
# Position, velocity, spin.
State = tuple[float, float, float, float, float, float, float, float, float]
# A number for each parameter of the catalogue, neutral where its effect is not in the list.
Parameters = Floats
# Wind and the pull of gravity: what is the same everywhere in flight.
Hall = tuple[Vector, Vector]
# Whether table and net are there, the surface's height and its unit normal.
Scene = tuple[bool, bool, float, Vector]
# Where the contacts of one ball are noted: times, surfaces, states before and after.
Record = tuple[Floats, Integers, Floats, Floats]
