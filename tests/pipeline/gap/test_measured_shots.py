"""Shots from a folder of recordings: which they are, and what they say of balls to come."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from experiments.exam.simulate.trial import CAMERAS
from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.gap.expected_balls import expected_balls, expected_json, read_expected
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.gap.summary import episodes_text
from rallygap.pipeline.runtime.errors import InputError
from tests.models.gap.hidden import NOMINAL, measured
from tests.pipeline.recorded import write_recordings


@pytest.mark.parametrize("noise", [0.003, 0.01])
def test_every_recorded_shot_is_found_with_its_labels_whatever_the_noise(tmp_path, noise):
    cameras = replace(CAMERAS, position_noise=noise)
    found = read_shots(write_recordings(tmp_path / "lab", shots=12, cameras=cameras), "csv")
    assert (found.name, found.recordings, len(found.shots)) == ("lab", 12, 12)
    assert found.shots.groups[0] == "lab/000"
    assert found.shots.labelled.sum(axis=1).min() > 10
    assert found.bounces > 0
    assert found.noise == pytest.approx(noise, rel=0.15)


def test_what_is_left_out_has_a_reason(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=12)
    short, spun = folder / "000.csv", folder / "001.csv"
    pd.read_csv(short).head(10).to_csv(short, index=False)
    rows = pd.read_csv(spun)
    rows.loc[:4, ["wx", "wy", "wz"]] = 4000.0
    rows.to_csv(spun, index=False)
    read = sum(len(pd.read_csv(path).dropna()) for path in folder.glob("*.csv"))
    with spun.open("a") as file:
        file.write("0.0,0,1,0.3,,,\n")
    found = read_shots(folder, "csv")
    assert found.refused["time backwards"] == 1
    assert episodes_text(found) == "11 of 12 episodes in 12 recordings; left out: 1 too short"
    assert (found.labels.read, found.labels.implausible, found.labels.elsewhere) == (read, 5, 10)
    assert found.labels.used == found.shots.labelled.sum()


@pytest.mark.parametrize(
    ("folder", "source", "problem"),
    [
        (".", "nowhere", r"no source .* known: .*csv"),
        (".", "arena", r"no source .* known: .*csv"),
        (".", "competitive_robot_table_tennis", "launches without a path"),
        ("lab", "csv", r"lab: is not a folder.* files of csv"),
    ],
)
def test_what_has_no_shots_is_refused(tmp_path, folder, source, problem):
    for name in ("rallies.json", "serves.json"):
        (tmp_path / name).write_text("[]")
    with pytest.raises(InputError, match=problem):
        read_shots(tmp_path / folder, source)


def test_noise_and_spins_are_those_of_the_shots():
    """Shots from both ends; spins about x are topspin from one and backspin from the other."""
    found = expected_balls(measured(count=60, noise=0.004), NOMINAL)
    assert found.noise == pytest.approx(0.004, rel=0.1)
    # Uniform between plus and minus 250, 80 and 120 rad/s about x, y and z.
    assert np.array(found.spin) == pytest.approx([0.0, 0.0, 0.0], abs=80.0)
    left = found.spin_spread[1]
    assert left == pytest.approx(1.4826 * 125.0, rel=0.3)
    assert max(found.spin_spread) == left


def test_a_file_has_the_balls_that_were_written(tmp_path):
    expected = Expected(0.0021, (3.0, -120.0, 0.5), (40.0, 300.0, 90.0))
    (tmp_path / "balls.json").write_text(expected_json(expected))
    assert read_expected(tmp_path / "balls.json") == expected


@pytest.mark.parametrize(
    ("content", "field"),
    [
        ('{"noise": 0, "spin": [0, 0, 0], "spin_spread": [1, 1, 1]}', "noise"),
        ('{"noise": 0.002, "spin": [0, 0], "spin_spread": [1, 1, 1]}', "spin"),
        ('{"noise": 0.002, "spin": [0, 0, 0]}', "spin_spread"),
    ],
)
def test_a_file_of_other_content_is_refused_by_its_field(tmp_path, content, field):
    (tmp_path / "balls.json").write_text(content)
    with pytest.raises(InputError, match=f"{field}.*give the balls.json of a verdict"):
        read_expected(tmp_path / "balls.json")
