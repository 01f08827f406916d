"""Folds of a cross-validation over recordings."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rallygap.pipeline.runtime.errors import InputError


def fold_numbers(set_name: str, recordings: NDArray[Any], count: int) -> NDArray[np.int64]:
    """Return (B,) the fold of each shot or episode; those of a recording are in the same one.

    Args:
        set_name: of the set.
        recordings: (B,) the recording of each.
        count: of folds.

    Raises:
        InputError: there are fewer recordings than folds.
    """
    names, member = np.unique(recordings.astype(str), return_inverse=True)
    if len(names) < count:
        problem = f"has shots of {len(names)} recordings, too few for {count} folds"
        raise InputError(set_name, problem)
    order: NDArray[np.int64] = np.random.default_rng(0).permutation(len(names))
    return order[member] % count
