"""Coverage of calibrated sets, and the shots that are shown."""

import json

import numpy as np
import pytest

from rallygap.models.predictors.calibration import LEVELS, Errors
from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.models.predictors.protocol import FUTURE_TIMES, History
from rallygap.models.predictors.windows import Windows
from rallygap.pipeline.evaluation.coverage import Coverage
from rallygap.pipeline.evaluation.example_shots import Forecast, Shot, read_shots, write_shots
from rallygap.pipeline.evaluation.forecasts import typical_first
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.report.example_reports import made_up_shots

HORIZONS = len(HORIZONS_MS)


def part(size, seed, count=400):
    """Errors of ``size`` m that are said to be of 1 cm."""
    away = size * np.random.default_rng(seed).normal(size=(count, HORIZONS, 3))
    return Errors(away, np.tile(0.01**2 * np.eye(3), (count, HORIZONS, 1, 1)))


def test_parts_alike_cover_what_the_levels_say():
    found = Coverage.crossed([part(0.03, seed) for seed in range(5)])
    table = found.table(np.arange(2000), 50, 0)
    for level in LEVELS:
        rows = table[table["level"] == level]
        assert rows["coverage"].mean() == pytest.approx(level, abs=0.02)
        assert (rows["n"] == 2000).all()


def test_a_part_does_not_calibrate_its_own_sets():
    parts = [part(0.001, 0), part(0.001, 1), part(0.1, 2)]
    covered = Coverage.crossed(parts).covered[LEVELS.index(0.9)]
    assert covered[-400:].mean() < 0.05  # sets by the accurate parts are too small for it
    assert covered[:400].mean() == 1.0


def test_shots_come_back_as_they_were_written(tmp_path):
    write_shots(tmp_path / "shots.json", made_up_shots())

    assert read_shots(tmp_path / "shots.json") == made_up_shots()


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda shot: shot["t"].sort(reverse=True), "0: .*t must increase"),
        (
            lambda shot: shot["forecasts"]["physics_c"]["position"].pop(),
            "0.forecasts.physics_c: .*position has 59 points for 60 times",
        ),
        (lambda shot: shot["measured"].append([0.0, 0.0, None]), "0.measured.*: .*valid number"),
        (lambda shot: shot.update(anchor=99.0), "0: .*anchor must lie within the measured times"),
        (lambda shot: shot.update(color="red"), "0.color: .*Extra inputs are not permitted"),
    ],
)
def test_broken_shot_is_refused_with_its_place(tmp_path, damage, message):
    path = tmp_path / "shots.json"
    write_shots(path, made_up_shots())
    content = json.loads(path.read_text())
    damage(content[0])
    path.write_text(json.dumps(content))

    with pytest.raises(InputError, match=f"shots.json, {message}"):
        read_shots(path)


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
