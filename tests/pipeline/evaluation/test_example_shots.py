"""Example shots: round trip through the file, and errors that name the place."""

import json

import pytest

from rallygap.pipeline.evaluation.example_shots import read_shots, write_shots
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.report.example_reports import made_up_shots


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
