"""Recordings with a usual mistake are refused, and the line of the message corrects it."""

import re
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.recorded import write_recordings

POSITIONS, SPINS = ["x", "y", "z"], ["wx", "wy", "wz"]
ABOVE_FLOOR = 0.76  # m, the table's surface
# Right-handed axes with y up, as graphics engines have them: rows are the table's x, y, z.
GRAPHICS = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
UPSIDE_DOWN = np.diag([-1, 1, -1])


@pytest.fixture(scope="module")
def correct(tmp_path_factory):
    """A folder of correct recordings."""
    return write_recordings(tmp_path_factory.mktemp("correct") / "lab", shots=30)


@pytest.fixture(scope="module")
def expected(correct):
    return read_shots(correct, "csv").shots


def scaled(columns, factor):
    return lambda rows: rows.assign(**{name: factor * rows[name] for name in columns})


def renamed(**names):
    return lambda rows: rows.rename(columns=names)


def swapped(one, other):
    return renamed(**{one: other, other: one, f"w{one}": f"w{other}", f"w{other}": f"w{one}"})


def turned(rotation):
    """Vectors in axes of which ``rotation`` leads to the table frame."""

    def turn(rows):
        new = rows.copy()
        for columns in (POSITIONS, SPINS):
            new[columns] = rows[columns].to_numpy() @ rotation
        return new

    return turn


def raised(height):
    return lambda rows: rows.assign(z=rows["z"] + height)


def both(first, second):
    return lambda rows: second(first(rows))


@dataclass(frozen=True)
class Mistake:
    """A change of correct rows, and the line that corrects it."""

    change: object
    line: str


MISTAKES = {
    "mm": Mistake(scaled(POSITIONS, 1000), "units: {position: mm}"),
    "cm": Mistake(scaled(POSITIONS, 100), "units: {position: cm}"),
    "ms": Mistake(scaled(["t"], 1000), "units: {time: ms}"),
    "us": Mistake(scaled(["t"], 1e6), "units: {time: us}"),
    "mm and ms": Mistake(
        both(scaled(POSITIONS, 1000), scaled(["t"], 1000)), "units: {position: mm, time: ms}"
    ),
    "rpm": Mistake(scaled(SPINS, 30 / np.pi), "units: {spin: rpm}"),
    "rev/s": Mistake(scaled(SPINS, 0.5 / np.pi), "units: {spin: rev/s}"),
    "deg/s": Mistake(scaled(SPINS, 180 / np.pi), "units: {spin: deg/s}"),
    "opposite spin": Mistake(scaled(SPINS, -1), "units: {spin: -rad/s}"),
    "opposite spin in rpm": Mistake(scaled(SPINS, -30 / np.pi), "units: {spin: -rpm}"),
    "y and z exchanged": Mistake(swapped("y", "z"), "axes: [x, z, y]"),
    "x and y exchanged": Mistake(swapped("x", "y"), "axes: [y, x, z]"),
    "x and z exchanged": Mistake(swapped("x", "z"), "axes: [z, y, x]"),
    "y up": Mistake(turned(GRAPHICS), "frame: {rotation: [[-1, 0, 0], [0, 0, 1], [0, 1, 0]]}"),
    "upside down": Mistake(
        turned(UPSIDE_DOWN), "frame: {rotation: [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]}"
    ),
    "from the floor": Mistake(raised(ABOVE_FLOOR), "frame: {offset: [0, 0, -0.76]}"),
}


def with_mistake(correct, folder, change):
    folder.mkdir()
    for path in correct.glob("*.csv"):
        rows = change(pd.read_csv(path))
        rows[["t", *POSITIONS, *SPINS]].to_csv(folder / path.name, index=False)
    (folder / "source.yaml").write_text("name: lab\nkind: cannon\n")
    return folder


def refusal(folder):
    with pytest.raises(InputError) as refused:
        read_shots(folder, "csv")
    assert len(str(refused.value).splitlines()) == 1
    return str(refused.value)


def correction(message):
    """The line that a message gives, in backquotes."""
    return re.search("`(.*)`", message)[1]


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
    mistake = MISTAKES[name]
    folder = with_mistake(correct, tmp_path / "lab", mistake.change)
    line = correction(refusal(folder))
    assert line == mistake.line
    with (folder / "source.yaml").open("a") as file:
        file.write(line + "\n")
    found = read_shots(folder, "csv").shots
    # Right-handed axes with y up leave open which end of the table is y > 0.
    mirror = {"y up": (-1, -1, 1)}.get(name, (1, 1, 1))
    assert same(found, expected, mirror)


def without_labels(rows):
    return rows.assign(**dict.fromkeys(SPINS, np.nan))


@pytest.mark.parametrize("name", ["mm", "ms", "y and z exchanged", "x and y exchanged"])
def test_positions_are_enough_without_labels(tmp_path, correct, name):
    mistake = MISTAKES[name]
    change = both(mistake.change, without_labels)
    assert correction(refusal(with_mistake(correct, tmp_path / "lab", change))) == mistake.line


@pytest.mark.parametrize(
    ("stated", "line"),
    [
        ("units: {position: mm}", "units: {}"),
        ("units: {position: mm, spin: rad/s}", "units: {}"),
        ("units: {time: ms}", "units: {}"),
        ("units: {spin: rpm}", "units: {}"),
        ("units: {spin: -deg/s}", "units: {}"),
        ("axes: [x, z, y]", "axes: [x, y, z]"),
        ("axes: [z, x, y]", "axes: [x, y, z]"),
        ("frame: {offset: [0, 0, -0.5]}", "frame: {}"),
    ],
)
def test_a_line_that_is_wrong_is_replaced(tmp_path, correct, stated, line):
    folder = with_mistake(correct, tmp_path / "lab", lambda rows: rows)
    (folder / "source.yaml").write_text(f"kind: cannon\n{stated}\n")
    assert correction(refusal(folder)) == line


def test_a_further_rotation_follows_the_stated_one(tmp_path, correct, expected):
    sideways = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    folder = with_mistake(correct, tmp_path / "lab", turned(sideways @ UPSIDE_DOWN))
    source = folder / "source.yaml"
    source.write_text("kind: cannon\nframe: {rotation: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]}\n")
    source.write_text(f"name: lab\nkind: cannon\n{correction(refusal(folder))}\n")
    assert same(read_shots(folder, "csv").shots, expected, (-1, -1, 1))


def test_a_ball_that_falls_too_fast_in_any_unit_is_refused(tmp_path, correct):
    folder = with_mistake(correct, tmp_path / "lab", scaled(["t"], 0.2))
    message = refusal(folder)
    assert "the ball falls with" in message and "`" not in message
