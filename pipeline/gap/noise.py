"""The noise of measured coordinates."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.settings import SegmentSettings

DIFFERENCE = np.sqrt(20.0)  # standard deviation of a third difference, in those of its samples
TO_DEVIATION = 1.4826  # from the median size of an error to its standard deviation
LARGEST_NOISE = 0.05  # m, beyond which nothing can be cut


def coordinate_noise(paths: Sequence[Floats]) -> float:
    """Return the noise of a coordinate, m: the median third difference, at least the usual noise.

    Smooth paths have hardly any third differences, and the median ignores contacts and outliers.

    Args:
        paths: (n, 3) positions of each recording, m.
    """
    usual = SegmentSettings().noise
    sizes = np.concatenate(
        [np.empty(0), *(np.abs(np.diff(path, 3, axis=0)).ravel() for path in paths)]
    )
    if not len(sizes):
        return usual
    return float(np.clip(TO_DEVIATION * np.median(sizes) / DIFFERENCE, usual, LARGEST_NOISE))
