"""The first shot that is shown has typical errors."""

import numpy as np

from rallygap.models.predictors.protocol import FUTURE_TIMES, History
from rallygap.models.predictors.windows import Windows
from rallygap.pipeline.evaluation.example_shots import Forecast, Shot
from rallygap.pipeline.evaluation.forecasts import typical_first


def window(measured_until=60):
    measured = np.zeros((1, 60, 9), dtype=bool)
    measured[:, :measured_until] = True
    history = History(np.zeros((1, 12, 6)), np.zeros((1, 12, 6), dtype=bool))
    bounced = np.zeros((1, 60), dtype=bool)
    return Windows(history, np.zeros(1), np.zeros((1, 60, 9)), measured, bounced)


def shot(name, **errors):
    """A shot at rest in the origin, whose forecasts are off by so many metres a second."""
    times = FUTURE_TIMES.tolist()
    forecasts = {
        one: Forecast(t=times, position=[(size * time, 0.0, 0.0) for time in times])
        for one, size in errors.items()
    }
    rest = {"t": [0.0], "measured": [(0.0, 0.0, 0.0)], "anchor": 0.0}
    return Shot(episode_id=name, source="made_up", forecasts=forecasts, **rest)


def test_the_shot_nearest_to_the_median_of_all_predictors_comes_first():
    shots = [
        shot("a", physics=0.01, network=0.02),
        shot("b", physics=0.30, network=0.10),
        shot("c", physics=0.10, network=0.05),
        shot("d", physics=0.09, network=0.90),
    ]
    found = typical_first(shots, [window()] * 4)
    assert [one.episode_id for one in found] == ["c", "a", "b", "d"]
    # Its errors are those of the last measured state.
    found = typical_first(shots, [window(), window(), window(10), window()])
    assert [one.episode_id for one in found] == ["a", "b", "c", "d"]
