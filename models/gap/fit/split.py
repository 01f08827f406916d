"""The split of shots into those that causes are named by and those held out for verification."""

import numpy as np

from models.gap.fit.shots import Shots
from models.gap.types import Bools

HELD_OUT = 3  # one shot in so many is held out; also the least number of shots


def held_out(shots: Shots) -> Bools:
    """Return (B,) which shots are held out: whole recordings where there are several."""
    groups, member = np.unique(shots.groups.astype(str), return_inverse=True)
    units = member if len(groups) >= 2 * HELD_OUT else np.arange(len(shots))
    order = np.random.default_rng(0).permutation(units.max() + 1)
    return np.asarray(order[units] % HELD_OUT == 0)
