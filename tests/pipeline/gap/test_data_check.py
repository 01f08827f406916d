"""Correct recordings pass the check, whatever their physics; those with a usual mistake are refused
with the line that corrects it.
"""

import re

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.recorded import write_recordings

# Sizes at or near the bounds of the catalogue; the pairs are the worst for spins and for axes.
LARGE = [
    {"gravity": {"g": 7.0}},
    {"drag": {"cd": 0.9}},
    {"magnus": {"cm": 0.0}},
    {"magnus": {"cm": 0.4}},
    {"magnus": {"cm": 0.33}, "spin_gain": {"s": -0.5}},
    {"lift_saturation": {"kappa": 20.0}, "spin_gain": {"s": 0.5}},
    {"lift_crisis": {"d": 2.0}},
    {"wind": {"x": 3.0, "y": 3.0}},
    {"frame_tilt": {"x": 0.2, "y": 0.2}},
    {"clock_rate": {"d": 0.2}, "position_scale": {"s": -0.1}},
    {"table_height": {"h": 0.03}},
]
POSITIONS, SPINS = ["x", "y", "z"], ["wx", "wy", "wz"]
SHOTS = 20
# Right-handed axes with y up, as graphics engines have them: rows are the table's x, y, z.
GRAPHICS = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
UPSIDE_DOWN = np.diag([-1, 1, -1])
SIDEWAYS = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])


@pytest.fixture(scope="module")
def correct(tmp_path_factory):
    """A folder of correct recordings."""
    return write_recordings(tmp_path_factory.mktemp("correct") / "lab", shots=SHOTS)


@pytest.fixture(scope="module")
def expected(correct):
    return read_shots(correct, "csv")


def scaled(columns, factor):
    return lambda rows: rows.assign(**{name: factor * rows[name] for name in columns})


def moved(**offsets):
    return lambda rows: rows.assign(**{name: rows[name] + by for name, by in offsets.items()})


def swapped(one, other):
    names = {one: other, other: one, f"w{one}": f"w{other}", f"w{other}": f"w{one}"}
    return lambda rows: rows.rename(columns=names)


def turned(rotation):
    """Vectors in axes of which ``rotation`` leads to the table frame."""

    def turn(rows):
        vectors = [rows[columns].to_numpy() @ rotation for columns in (POSITIONS, SPINS)]
        return rows.assign(**dict(zip([*POSITIONS, *SPINS], np.hstack(vectors).T, strict=True)))

    return turn


def unlabelled(rows):
    return rows.assign(**dict.fromkeys(SPINS, np.nan))


# By name, a change of correct rows, and the line that corrects it.
MISTAKES = {
    "mm": (scaled(POSITIONS, 1000), "units: {position: mm}"),
    "cm": (scaled(POSITIONS, 100), "units: {position: cm}"),
    "ms": (scaled(["t"], 1000), "units: {time: ms}"),
    "us": (scaled(["t"], 1e6), "units: {time: us}"),
    "mm and ms": (scaled([*POSITIONS, "t"], 1000), "units: {position: mm, time: ms}"),
    "rpm": (scaled(SPINS, 30 / np.pi), "units: {spin: rpm}"),
    "rev/s": (scaled(SPINS, 0.5 / np.pi), "units: {spin: rev/s}"),
    "deg/s": (scaled(SPINS, 180 / np.pi), "units: {spin: deg/s}"),
    "opposite spin": (scaled(SPINS, -1), "units: {spin: -rad/s}"),
    "opposite spin in rpm": (scaled(SPINS, -30 / np.pi), "units: {spin: -rpm}"),
    "y and z exchanged": (swapped("y", "z"), "axes: [x, z, y]"),
    "x and y exchanged": (swapped("x", "y"), "axes: [y, x, z]"),
    "x and z exchanged": (swapped("x", "z"), "axes: [z, y, x]"),
    "y up": (turned(GRAPHICS), "frame: {rotation: [[-1, 0, 0], [0, 0, 1], [0, 1, 0]]}"),
    "upside down": (
        turned(UPSIDE_DOWN), "frame: {rotation: [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]}"
    ),
    "from the floor": (moved(z=0.76), "frame: {offset: [0, 0, -0.76]}"),
}  # fmt: skip


def changed(correct, folder, change, source="name: lab\nkind: cannon\n"):
    """The correct recordings, changed, with a source.yaml."""
    folder.mkdir()
    for path in correct.glob("*.csv"):
        rows = change(pd.read_csv(path))
        rows[["t", *POSITIONS, *SPINS]].to_csv(folder / path.name, index=False)
    (folder / "source.yaml").write_text(source)
    return folder


def refusal(folder):
    """The message about a folder, and the line that it gives in backquotes."""
    with pytest.raises(InputError) as refused:
        read_shots(folder, "csv")
    (message,) = str(refused.value).splitlines()
    return message, "".join(re.findall("`(.*)`", message))


def same(shots, expected, mirror=(1, 1, 1)):
    """Whether shots are the expected ones; ``mirror`` are the signs of the axes."""
    signs = np.array(mirror)
    return (
        np.allclose(shots.times, expected.times, atol=1e-9)
        and np.allclose(shots.positions, signs * expected.positions, atol=1e-9)
        and np.allclose(shots.labels, signs * expected.labels, rtol=1e-9, equal_nan=True)
    )


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_refused_with_the_line_that_corrects_it(tmp_path, correct, expected, name):
    change, right = MISTAKES[name]
    folder = changed(correct, tmp_path / "lab", change)
    assert refusal(folder)[1] == right
    with (folder / "source.yaml").open("a") as file:
        file.write(right + "\n")
    # Right-handed axes with y up leave open which end of the table is y > 0.
    mirror = {"y up": (-1, -1, 1)}.get(name, (1, 1, 1))
    assert same(read_shots(folder, "csv").shots, expected.shots, mirror)


@pytest.mark.parametrize("name", ["mm", "ms", "y and z exchanged", "x and y exchanged"])
def test_positions_are_enough_without_labels(tmp_path, correct, name):
    change, line = MISTAKES[name]
    folder = changed(correct, tmp_path / "lab", lambda rows: unlabelled(change(rows)))
    assert refusal(folder)[1] == line


@pytest.mark.parametrize(
    ("stated", "line"),
    [
        ("units: {position: mm, spin: rad/s}", "units: {}"),
        ("units: {spin: -deg/s}", "units: {}"),
        ("axes: [x, z, y]", "axes: [x, y, z]"),
        ("frame: {offset: [0, 0, -0.5]}", "frame: {}"),
    ],
)
def test_a_line_that_is_wrong_is_replaced(tmp_path, correct, stated, line):
    folder = changed(correct, tmp_path / "lab", lambda rows: rows, f"kind: cannon\n{stated}\n")
    assert refusal(folder)[1] == line


def test_a_further_rotation_follows_the_stated_one(tmp_path, correct, expected):
    stated = "kind: cannon\nframe: {rotation: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]}\n"
    folder = changed(correct, tmp_path / "lab", turned(SIDEWAYS @ UPSIDE_DOWN), stated)
    _, line = refusal(folder)
    (folder / "source.yaml").write_text(f"name: lab\nkind: cannon\n{line}\n")
    assert same(read_shots(folder, "csv").shots, expected.shots, (-1, -1, 1))


def test_what_no_unit_explains_is_refused_without_a_line(tmp_path, correct):
    message, line = refusal(changed(correct, tmp_path / "lab", scaled(["t"], 0.2)))
    assert "the ball falls with" in message and not line


@pytest.mark.parametrize("causes", LARGE, ids=lambda causes: " ".join(causes))
def test_large_effects_do_not_stop(tmp_path, causes):
    assert len(read_shots(write_recordings(tmp_path / "lab", causes, shots=15), "csv").shots) > 10


@pytest.mark.parametrize(
    ("causes", "settings", "doubt"),
    [
        ({"table_height": {"h": 0.05}}, {}, "bounce at z = 70 mm"),
        ({"table_tilt": {"x": 0.03, "y": 0.03}}, {}, "heights of bounces rise by 4. mm/m"),
        ({"wind": {"z": 5.0}}, {}, "instead of 9.81"),
        ({}, {"time_resolution": 1e-3}, "rounded to 1 ms"),
        ({"spin_sign_flip": {"share": 0.8}}, {}, "curve against their spin labels"),
    ],
)
def test_what_is_doubtful_is_said(tmp_path, causes, settings, doubt):
    folder = write_recordings(tmp_path / "lab", causes, shots=30, **settings)
    assert pd.Series(read_shots(folder, "csv").doubts).str.contains(doubt).any()


def test_where_balls_are_may_be_doubtful(tmp_path, correct, expected):
    across = swapped("x", "y")
    changes = {
        "the origin is at": moved(x=0.7625, y=1.37),
        "fly along x": lambda rows: unlabelled(across(rows)).head(35),  # no bounce decides
    }
    for number, (doubt, change) in enumerate(changes.items()):
        folder = changed(correct, tmp_path / str(number), change)
        assert any(doubt in one for one in read_shots(folder, "csv").doubts)
    assert expected.doubts == ()


@pytest.mark.real
@pytest.mark.parametrize("source", ["spindoe", "tt3d", "isr_ball_prediction"])
def test_measured_sets_pass(real_data, source):
    assert len(read_shots(real_data / source, source).shots) > 50
