"""Heights: a ball that bounces on the table has its centre 20 mm above z = 0."""

import numpy as np

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.ball.types import Floats
from rallygap.pipeline.gap.data_check.problem import Problem, Setup

BAND = 0.06  # m to either side of the most frequent height
FEWEST_BOUNCES = 3
LEAST_SHARE = 0.5  # of all bounces at the most frequent height
WRONG, DOUBTFUL = 0.10, 0.04  # m from the expected height
FLOOR = 0.76  # m from the floor to the table's surface, ITTF Law 2.1
NEAR_FLOOR = 0.01  # m, within which the official height is meant
STEEP = 0.03  # slope of the surface that bounces show
FEWEST_SLOPE = 10  # bounces that show a slope


def height_problem(places: Floats, setup: Setup) -> Problem | None:
    """Return what is wrong with the heights of bounces at (n, 3) places."""
    height, share = _usual(places)
    if share < LEAST_SHARE or abs(height - BALL_RADIUS) < WRONG:
        return None
    surface = height - BALL_RADIUS
    from_floor = abs(surface - FLOOR) < NEAR_FLOOR
    offset = np.array([0.0, 0.0, -FLOOR if from_floor else -round(surface, 3)])
    origin = "the floor" if abs(surface - FLOOR) < BAND else "another place"
    text = f"heights are from {origin}, not the table: balls bounce at z = {height:.3f} m, not 0.02"
    return Problem(text, setup.frame_line(np.eye(3), offset))


def height_doubts(places: Floats) -> list[str]:
    """Return what is doubtful about the heights of bounces."""
    height, share = _usual(places)
    doubts = []
    if share >= LEAST_SHARE and abs(height - BALL_RADIUS) > DOUBTFUL:
        doubts.append(
            f"balls bounce at z = {1000 * height:.0f} mm; on the table it is 20 mm: check the "
            "origin of heights"
        )
    slope = _slope(places)
    if slope > STEEP:
        doubts.append(
            f"the heights of bounces rise by {1000 * slope:.0f} mm/m over the table: check the "
            "axes' directions"
        )
    return doubts


def _usual(places: Floats) -> tuple[float, float]:
    """Return the most frequent height of bounces, and the share of bounces near it."""
    heights = places[:, 2]
    if len(heights) < FEWEST_BOUNCES:
        return BALL_RADIUS, 0.0
    near = np.abs(heights[:, None] - heights) < BAND
    most = near[np.argmax(near.sum(axis=1))]
    return float(np.median(heights[most])), float(most.mean())


def _slope(places: Floats) -> float:
    """Return the slope of the plane through the bounces at the most frequent height."""
    chosen = places[np.abs(places[:, 2] - _usual(places)[0]) < BAND]
    if len(chosen) < FEWEST_SLOPE:
        return 0.0
    terms = np.column_stack([chosen[:, :2] - chosen[:, :2].mean(axis=0), np.ones(len(chosen))])
    return float(np.linalg.norm(np.linalg.lstsq(terms, chosen[:, 2])[0][:2]))
