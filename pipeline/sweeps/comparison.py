"""Paired comparison of two parameter sets on the same shots, with several seeds."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.predictors.errors import error_statistics
from rallygap.models.predictors.protocol import Floats

SEEDS = 3
RESAMPLES = 2000  # of the bootstrap


def repeat_seed(seed: int, repeat: int) -> int:
    """Return the seed of a repeat; trials are repeat 0."""
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0])


def comparison(
    measures: Sequence[str], smaller_is_better: bool, results: Floats, groups: NDArray, seed: int
) -> pd.DataFrame:
    """Compare the results of S seeds on the same N shots or windows, with both parameter sets.

    Args:
        measures: names of the K measures; the first decides.
        smaller_is_better: of all measures.
        results: (2 S, N, K) with params.yaml, then with the best parameters of the sweep; NaN
            where nothing was measured.
        groups: (S, N) labels; the bootstrap resamples whole groups.
        seed: of the bootstrap.

    Returns:
        One row per measure: means, difference with its 95 % interval, and per seed. ``holds``: the
        whole interval and the differences of all seeds are on the better side.
    """
    params, best = results[: len(groups)], results[len(groups) :]
    difference = best - params
    flat = difference.reshape(-1, len(measures))
    statistics = error_statistics(flat, groups.ravel(), RESAMPLES, np.random.default_rng(seed))
    by_seed = np.nanmean(difference, axis=1)
    sign = -1 if smaller_is_better else 1
    columns = {
        "measure": list(measures),
        "params": np.nanmean(params, axis=(0, 1)),
        "found": np.nanmean(best, axis=(0, 1)),
        "difference": statistics.mean,
        "ci_low": statistics.low,
        "ci_high": statistics.high,
        **{f"seed_{k + 1}": differences for k, differences in enumerate(by_seed)},
        "n": statistics.count,
        "holds": np.all(sign * np.stack([statistics.low, statistics.high, *by_seed]) > 0, axis=0),
    }
    return pd.DataFrame(columns)
