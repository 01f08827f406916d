"""Trials: trained policies play balls that somebody forecasts for them."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pandas as pd

from models.ball.simulator import Simulator
from models.policy.comparison import forecast_error
from models.policy.goals import Goals
from models.policy.incoming_balls import Incoming
from models.policy.policy import Policy
from models.policy.trial import play
from pipeline.policies.storage import TrainedPolicy
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar


class Trial(Protocol):
    """Something to be played."""

    def results(self) -> pd.DataFrame:
        """Play; return one row a policy and ball."""
        ...


def play_all(trials: Sequence[Trial]) -> pd.DataFrame:
    """Return the results of all trials, in their order, played side by side."""
    tables: list[pd.DataFrame] = []
    with progress_bar("trials", len(trials)) as advance:
        for table in parallel([trial.results for trial in trials]):
            tables.append(table)
            advance()
    return pd.concat(tables, ignore_index=True)


def try_policy(
    policy: Policy, trained: TrainedPolicy, simulator: Simulator, incoming: Incoming, goals: Goals
) -> pd.DataFrame:
    """Return how each ball ended: what ``play`` tells, and who played.

    Args:
        policy: plays.
        trained: what for.
        simulator: flies the balls on from the racket.
        incoming: (B,) balls, forecast at the horizons that the policy wants.
        goals: (B,) of their returns.

    Returns:
        One row a ball: columns of ``play``; ``horizons_ms`` and ``repeat`` of the policy;
        ``ball``, which counts them; and ``forecast_error_m``, the same in all rows.
    """
    return play(policy, simulator, incoming, goals, trained.observation).assign(
        horizons_ms=trained.horizons_label,
        repeat=trained.repeat,
        ball=np.arange(len(incoming)),
        forecast_error_m=forecast_error(incoming, trained.horizons),
    )
