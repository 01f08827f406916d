"""The bootstrap by cluster: recordings, matches or shots are resampled whole."""

import numpy as np
from numpy.typing import NDArray


def resampled_counts(
    clusters: int, resamples: int, random: np.random.Generator
) -> NDArray[np.int64]:
    """Return (resamples, clusters) how often each resample has each of the clusters."""
    return random.multinomial(clusters, np.full(clusters, 1 / clusters), size=resamples)
