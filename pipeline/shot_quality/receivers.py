"""How winning probabilities depend on the receiver that the forest's training points have."""

from collections.abc import Mapping
from dataclasses import asdict
from itertools import combinations

import numpy as np
import pandas as pd

from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.types import Floats
from rallygap.models.shot_quality.forest import Forest
from rallygap.models.shot_quality.receivers import RECEIVERS, play_against
from rallygap.pipeline.params import ShotQualitySettings
from rallygap.pipeline.shot_quality.returns import KEYS

OTHER_ARENA = 1  # added to the seed: the truth of the run's own arena stays sealed
NOMINAL = RECEIVERS[0].name


def receiver_forests(
    settings: ShotQualitySettings, seed: int
) -> tuple[pd.DataFrame, dict[str, Forest]]:
    """Simulate points against every receiver and train a forest on each.

    Returns:
        One row a receiver, ``win_rate`` the share of the shots that won; and receiver to forest.
    """
    truth = draw_truth(seed + OTHER_ARENA)
    rows, forests = [], {}
    for receiver in RECEIVERS:
        random = np.random.default_rng([seed, *b"receivers", receiver.draw])
        shots = play_against(receiver, truth, settings.points, random)
        forests[receiver.name] = Forest(shots.features, shots.wins, settings.forest, seed)
        rows.append({**asdict(receiver), "shots": len(shots), "win_rate": shots.wins.mean()})
    return pd.DataFrame(rows).rename(columns={"name": "receiver"}), forests


def median_win_probabilities(
    returns: pd.DataFrame, features: Floats, forests: Mapping[str, Forest]
) -> pd.DataFrame:
    """Return the median winning probability of every experiment, one column a forest."""
    probabilities = {name: forest.probabilities(features) for name, forest in forests.items()}
    return returns[KEYS].assign(**probabilities).groupby(KEYS, sort=False)[list(forests)].median()


def order_agreement(medians: pd.DataFrame, forest: str, reference: str = NOMINAL) -> float:
    """Return the share of pairs of experiments that two forests put in the same order.

    Pairs are on the same set and horizons. A tie agrees with a tie alone. NaN without any pair.
    """
    agreements = []
    for _, group in medians.groupby(KEYS[:2], sort=False):
        for experiment, other in combinations(group.index, 2):
            difference = group.loc[experiment] - group.loc[other]
            agreements.append(np.sign(difference[forest]) == np.sign(difference[reference]))
    return float(np.mean(agreements)) if agreements else np.nan
