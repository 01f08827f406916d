"""Types of the compiled functions: tuples, which stay in registers, and numpy arrays."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]

Vector = tuple[float, float, float]
# Position, velocity, spin.
State = tuple[float, float, float, float, float, float, float, float, float]
# One value per parameter of the catalogue, neutral where the simulator lacks the effect.
Parameters = Floats
# Wind (m/s) and gravitational acceleration (m/s^2), constant in flight.
Environment = tuple[Vector, Vector]
# Whether table and net exist, the height of the surface and its unit normal.
Scene = tuple[bool, bool, float, Vector]
# Contacts of one ball: times, surfaces, states before and after.
Record = tuple[Floats, Integers, Floats, Floats]
