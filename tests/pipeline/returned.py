"""Trials of sim2real with the states of their returns, by racket_state."""

from itertools import product

import numpy as np
import pandas as pd

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge
from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.transfer.returns import with_states

SIMULATOR = shipped("literature")
STRUCK = np.array([0.0, -1.6, 0.25, 0.0, 5.5, 1.6, -60.0, 0.0, 0.0])
PREDICTORS = {"physics": 0.0, "transformer": 0.4}  # m/s by which they strike faster


def trials(balls=12, seed=0):
    """Two policies, two horizons and two sets; everyone plays the same balls of a set."""
    parts = []
    sets, horizons = ("stroke_pro", "receive"), ("115-125", "170-180")
    for name, ahead, predictor, repeat in product(sets, horizons, PREDICTORS, range(2)):
        random = np.random.default_rng([seed, len(parts)])
        played = _played(balls, PREDICTORS[predictor], random)
        keys = {"set": name, "horizons_ms": ahead, "predictor": predictor, "repeat": repeat}
        parts.append(played.assign(**keys, protocol="every_tick"))
    return pd.concat(parts, ignore_index=True)


def _played(balls, faster, random):
    after = STRUCK + random.normal(
        scale=[0.1, 0.1, 0.05, 0.3, 0.4, 0.3, 30, 10, 10], size=(balls, 9)
    )
    after[:, 4] += faster
    outcome = judge(SIMULATOR, after, Goals(np.zeros((balls, 2))))
    played = pd.DataFrame(
        {"ball": np.arange(balls), "returned": outcome.returned, "speed": outcome.speed,
         "net_height": outcome.net_height}
    )  # fmt: skip
    return with_states(played, after, outcome.before_landing)


def write_trials(root, played):
    """Write trials as sim2real would."""
    write_table(root / "artifacts" / "sim2real" / "played.parquet", played)
