"""Hand-made trials of sim-to-real: which policy returned which ball with which predictor."""

import numpy as np
import pandas as pd

KEYS = ["set", "horizons_ms", "predictor", "protocol"]


def trials(returned, repeat=0, predictor="physics", protocol="every_tick", **other):
    """Trials of one policy on as many balls; the returned ones and the last were hit."""
    balls = np.arange(len(returned))
    columns = {
        "set": "stroke_pro", "horizons_ms": "115-125", "repeat": repeat, "predictor": predictor,
        "protocol": protocol, "ball": balls, "returned": np.array(returned, dtype=bool),
    }  # fmt: skip
    hit = columns["returned"] | (balls == balls[-1])
    return pd.DataFrame({**columns, "hit": hit, **other})


def everything():
    """Two policies, three forecasters, two horizons."""
    parts = [
        trials([1, 0, 0, 0], 0), trials([1, 1, 0, 0], 1),
        trials([1, 1, 1, 0], 0, "transformer"), trials([1, 0, 1, 0], 1, "transformer"),
        trials([0, 0, 0, 0], 0, "physics", "first_window"),
        trials([1, 0, 0, 0], 1, "physics", "first_window"),
    ]  # fmt: skip
    near = pd.concat(parts)
    return pd.concat([near, near.assign(horizons_ms="170-180")], ignore_index=True)
