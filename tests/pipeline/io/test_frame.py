"""Rigid motion into the table frame."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS

COLUMNS = [*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]
VECTORS = arrays(float, (4, 9), elements=st.floats(-10, 10))


@settings(max_examples=20)
@given(VECTORS, st.integers(0, 2**32 - 1))
def test_distances_speeds_and_the_turn_of_the_ball_are_kept(values, seed):
    rotation = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    rows = pd.DataFrame(values, columns=COLUMNS)
    moved = Frame(rotation=rotation.tolist(), offset=(1, 2, 3)).to_table(rows)
    ways = [np.diff(table[POSITION_COLUMNS], axis=0) for table in (rows, moved)]
    assert np.allclose(*(np.linalg.norm(way, axis=1) for way in ways))
    # The Magnus force w x v turns with the axes, as a real vector does.
    forces = [np.cross(table[SPIN_COLUMNS], table[VELOCITY_COLUMNS]) for table in (rows, moved)]
    assert np.allclose(forces[0] @ rotation.T, forces[1], atol=1e-9)


def test_the_offset_is_where_the_sources_origin_lies():
    origin = pd.DataFrame(np.zeros((1, 3)), columns=POSITION_COLUMNS)
    frame = Frame(rotation=((0, 1, 0), (-1, 0, 0), (0, 0, 1)), offset=(1, 2, 3))
    assert frame.to_table(origin).to_numpy().tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("rotation", "problem"),
    [
        (((1, 0, 0), (0, 1, 0), (0, 0, -1)), "mirrors"),
        (((1.01, 0, 0), (0, 1, 0), (0, 0, 1)), "unit vectors"),
        (((1, 0.01, 0), (0, 1, 0), (0, 0, 1)), "unit vectors"),
        (((0, 0, 0), (0, 0, 0), (0, 0, 0)), "unit vectors"),
    ],
)
def test_what_is_no_rotation_is_refused(rotation, problem):
    with pytest.raises(ValidationError, match=problem):
        Frame(rotation=rotation)
