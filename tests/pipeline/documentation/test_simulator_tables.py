"""Tables of users' own simulators, from small reports."""

import json

import pytest

from rallygap.pipeline.documentation.simulator_tables import (
    larger_spins_table,
    real_scenes_table,
    scenes_table,
)


@pytest.fixture
def write(tmp_path):
    folder = tmp_path / "reports/simulators"
    folder.mkdir(parents=True)

    def written(name, content):
        (folder / name).write_text(json.dumps(content))
        return tmp_path

    return written


def test_a_scene_has_a_row(write):
    right = {
        "hidden": "no density",
        "traps": ["no_drag", "no_lift"],
        "verdict": "named",
        "leading": ["drag.cd"],
        "named_right": True,
        "before_mm": 312.41,
        "after_mm": 0.6218,
        "floor_mm": 0.0,
        "removable_closed": 0.998,
    }
    missed = right | {"traps": [], "verdict": "no_gap", "leading": [], "named_right": False}
    root = write("scenes.json", {"mujoco": {"vacuum": right}, "pybullet": {"vacuum": missed}})
    assert scenes_table(root).splitlines()[2:] == [
        "| MuJoCo | no density | `no_drag`, `no_lift` | named | `drag.cd` | yes "
        "| 312.4 → 0.6 (0.0) | 100 % |",
        "| PyBullet | no density | – | no_gap | – | no | 312.4 → 0.6 (0.0) | 100 % |",
    ]


def test_a_scene_on_a_measured_set_has_the_causes_that_all_its_verdicts_have(write):
    one = {
        "shots": [30, 29, 21],
        "before_mm": [20.4, 61.0, 99.9],
        "after_mm": [15.2, 40.0, 71.6],
        "floor_mm": [14.0, 39.0, 70.0],
        "fall_mm": [9.1, 31.7],
        "verdicts": ["ambiguous", "named"],
        "leading": [["magnus.cm", "wind.y"], ["drag.cd", "magnus.cm"]],
    }
    root = write("real.json", {"tt3d": {"lab/scene": one}})
    assert real_scenes_table(root).splitlines()[-1] == (
        "| tt3d | lab/scene | 30, 29, 21 | 20 → 15 (14) | 61 → 40 (39) | 100 → 72 (70) "
        "| 9 to 32 | ambiguous, named | `magnus.cm` |"
    )


def test_games_with_larger_spins_have_a_row_for_each_factor(write):
    one = {
        "factor": 1.7,
        "spin_median": 76.4,
        "spin_p95": 156.5,
        "bend_mm": 60.7,
        "strokes_a_point": 5.29,
        "ended_by": {"missed": 0.115, "net": 0.275, "out": 0.576, "double_bounce": 0.034},
    }
    root = write("larger_spins.json", {"amateur": [one]})
    assert larger_spins_table(root).splitlines()[-1] == (
        "| amateur | 1.7 | 76, 156 | 61 | 5.3 | 28, 58, 12 |"
    )
