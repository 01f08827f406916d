"""Scores: how well a policy plays, told from how its balls ended."""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from models.policy.trial import STYLE


def scores(played: pd.DataFrame) -> dict[str, float]:
    """Return the scores of a policy.

    Args:
        played: how balls ended, as ``play`` tells it.

    Returns:
        ``hit_rate`` and ``return_rate``, shares of the balls; and of the balls that were returned
        ``landing_error_m``, the mean distance from goal to landing, and, where goals ask for them,
        ``speed_slope`` and ``topspin_slope``, by how much what is achieved grows with what is
        asked for: 1 would be perfect, 0 blind. NaN where that cannot be told.
    """
    returns = played[played["returned"]]
    slopes = {
        f"{name}_slope": fitted_line(returns[f"goal_{name}"], returns[name])[0]
        for name in STYLE
        if f"goal_{name}" in played
    }
    return {
        "return_rate": float(played["returned"].mean()),
        "hit_rate": float(played["hit"].mean()),
        "landing_error_m": float(returns["distance"].mean()),
        **slopes,
    }


def fitted_line(asked: ArrayLike, achieved: ArrayLike) -> tuple[float, float]:
    """Return slope and intercept of the least-squares line through (N,) points.

    NaN where fewer than two different things were asked for.
    """
    x, y = np.asarray(asked, dtype=np.float64), np.asarray(achieved, dtype=np.float64)
    if len(x) == 0 or np.ptp(x) == 0:
        return np.nan, np.nan
    slope, intercept = np.polyfit(x, y, 1)
    return float(slope), float(intercept)
