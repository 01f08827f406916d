"""What shots say of the balls to come is their noise, and their spins about their course."""

import numpy as np
import pytest

from rallygap.models.predictors.ball_filter import Expected
from rallygap.pipeline.gap.expected_balls import expected_balls, expected_json, read_expected
from rallygap.pipeline.runtime.errors import InputError
from tests.models.gap.hidden import NOMINAL, measured


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
