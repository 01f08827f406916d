"""Scores of a policy, computed from the outcomes of its trials."""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from rallygap.models.policy.episodes import STYLE


def scores(played: pd.DataFrame) -> dict[str, float]:
    """Return the scores of a policy.

    Args:
        played: the ``table`` of a ``TrialResult``.

    Returns:
        ``hit_rate`` and ``return_rate`` of all balls; of the returns ``landing_error_m``, the mean
        distance from the goal, and where there are such goals ``speed_slope`` and
        ``topspin_slope``, the slopes of the achieved value over the goal: 1 is perfect, 0 no
        response. NaN where undefined.
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


def fitted_line(goals: ArrayLike, achieved: ArrayLike) -> tuple[float, float]:
    """Return slope and intercept of the least-squares line through (N,) points.

    NaN for fewer than two different goals.
    """
    x, y = np.asarray(goals, dtype=np.float64), np.asarray(achieved, dtype=np.float64)
    if len(x) == 0 or np.ptp(x) == 0:
        return np.nan, np.nan
    slope, intercept = np.polyfit(x, y, 1)
    return float(slope), float(intercept)
