"""Coverage of calibrated sets, and the shots that are shown."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from rallygap.models.predictors.calibration import LEVELS, Errors
from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.pipeline.evaluation.coverage import Coverage
from rallygap.pipeline.evaluation.example_shots import Forecast, read_shots, write_shots
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


def shot(name, *sizes):
    """A shot in the origin, whose forecasts are off by so many metres."""
    forecasts = {
        str(size): Forecast.model_construct(position=np.full((60, 3), size)) for size in sizes
    }
    return made_up_shots()[0].model_copy(update={"episode_id": name, "forecasts": forecasts})


def test_the_shot_nearest_to_the_median_of_all_predictors_comes_first():
    sizes = {"a": (0.01, 0.02), "b": (0.30, 0.10), "c": (0.10, 0.05), "d": (0.09, 0.90)}
    cut = SimpleNamespace(measured=np.ones((1, 60, 9), dtype=bool), future=np.zeros((1, 60, 9)))
    found = typical_first([shot(name, *both) for name, both in sizes.items()], [cut] * 4)
    assert [one.episode_id for one in found] == ["c", "a", "b", "d"]
