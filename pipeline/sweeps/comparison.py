"""Paired comparison of two parameter sets on the same shots, with several seeds."""

from dataclasses import dataclass
from typing import Any

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


@dataclass(frozen=True)
class Comparison:
    """Results of S seeds on the same N shots or windows, with both parameter sets.

    Attributes:
        measures: names of the K measures; the first decides.
        smaller_is_better: of all measures.
        params: (S, N, K) with params.yaml; NaN where nothing was measured.
        found: (S, N, K) with the best parameters of the sweep.
        groups: (S, N) labels; the bootstrap resamples whole groups.
    """

    measures: list[str]
    smaller_is_better: bool
    params: Floats
    found: Floats
    groups: NDArray[Any]

    def table(self, seed: int) -> pd.DataFrame:
        """Return one row per measure: means, difference with its 95 % interval, and per seed.

        ``holds``: the whole interval and the differences of all seeds are on the better side.
        """
        difference = self.found - self.params
        flat = difference.reshape(-1, len(self.measures))
        found = error_statistics(flat, self.groups.ravel(), RESAMPLES, np.random.default_rng(seed))
        by_seed = np.nanmean(difference, axis=1)
        sign = -1 if self.smaller_is_better else 1
        columns = {
            "measure": self.measures,
            "params": np.nanmean(self.params, axis=(0, 1)),
            "found": np.nanmean(self.found, axis=(0, 1)),
            "difference": found.mean,
            "ci_low": found.low,
            "ci_high": found.high,
            **{f"seed_{k + 1}": differences for k, differences in enumerate(by_seed)},
            "n": found.count,
            "holds": np.all(sign * np.stack([found.low, found.high, *by_seed]) > 0, axis=0),
        }
        return pd.DataFrame(columns)
