"""Two settings, judged by the same balls: the parameters as they are and what a sweep found."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.predictors.errors import spread

Floats = NDArray[np.float64]

SEEDS = 3
RESAMPLES = 2000  # of the groups, for the 95 % intervals


def repeat_seed(seed: int, repeat: int) -> int:
    """Return the seed of a repeat, the same for all that is compared; trials are repeat 0."""
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0])


@dataclass(frozen=True)
class Judged:
    """What came of the same balls under two settings, each trained with S seeds.

    Attributes:
        measures: what was measured, K names; the first decides.
        smaller_is_better: whether less of them is better.
        params: (S, N, K) with the parameters as they are; NaN where nothing was measured.
        found: (S, N, K) with those that the sweep found.
        groups: (S, N) what is not independent of one another: resampled as a whole.
    """

    measures: list[str]
    smaller_is_better: bool
    params: Floats
    found: Floats
    groups: NDArray[Any]

    def table(self, seed: int) -> pd.DataFrame:
        """Return one row a measure: means, their difference with its interval, and of each seed.

        ``holds`` where the whole interval and the difference of every seed are on the better side.
        """
        apart = self.found - self.params
        flat = apart.reshape(-1, len(self.measures))
        found = spread(flat, self.groups.ravel(), RESAMPLES, np.random.default_rng(seed))
        by_seed = np.nanmean(apart, axis=1)
        sign = -1 if self.smaller_is_better else 1
        ends = np.stack([sign * found.low, sign * found.high, *(sign * by_seed)])
        columns = {
            "measure": self.measures,
            "params": np.nanmean(self.params, axis=(0, 1)),
            "found": np.nanmean(self.found, axis=(0, 1)),
            "difference": found.mean,
            "ci_low": found.low,
            "ci_high": found.high,
            **{f"seed_{k + 1}": differences for k, differences in enumerate(by_seed)},
            "n": found.count,
            "holds": np.all(ends > 0, axis=0),
        }
        return pd.DataFrame(columns)
