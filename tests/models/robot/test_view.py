"""Pictures: what is in them can be seen, and they are the same each time."""

import numpy as np

from rallygap.models.robot.constants import NEUTRAL
from rallygap.models.robot.view import HEIGHT, WIDTH, frames

POSES = np.tile(NEUTRAL, (2, 1))
BALLS = np.array([[0.1, 0.8, 0.4], [np.nan, np.nan, np.nan]])


def pixels(picture, dominant, others):
    """How many pixels are much stronger in one colour than in the others."""
    values = picture.astype(int)
    return int((values[..., dominant] > 60 + values[..., others].max(axis=-1)).sum())


def test_table_racket_and_a_ball_that_is_there_are_seen():
    pictures = frames(POSES, BALLS)
    assert pictures[0].shape == (HEIGHT, WIDTH, 3)
    assert pixels(pictures[0], 2, [0, 1]) > 5000
    assert pixels(pictures[0], 0, [1, 2]) > 100
    rows, columns, _ = np.nonzero(pictures[0] != pictures[1])
    assert 20 < len(set(zip(rows, columns, strict=True))) < 200
    assert np.ptp(rows) < 12 and np.ptp(columns) < 12
