"""Residual of a flight: distance of its samples from a least-squares path."""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from models.ball.types import Bools, Floats
from models.segmentation.flight import DRAG


def flight_residuals(t: Floats, x: Floats, velocity: Floats, used: Bools) -> Floats:
    """Return each sample's distance from a path with nominal drag and one constant acceleration.

    The constant stands for gravity, lift and a wrong drag coefficient. It cannot follow a contact,
    which the flight filter with its white jerk can.

    Args:
        t: times (n,), s.
        x: positions (n, 3), m.
        velocity: (n, 3), m/s, for the drag.
        used: (n,) the samples that the path is fitted to.

    Returns:
        Distances (n,), m.
    """
    drag = -DRAG * np.linalg.norm(velocity, axis=1, keepdims=True) * velocity
    slowed = cumulative_trapezoid(drag, t, axis=0, initial=0)
    displaced = cumulative_trapezoid(slowed, t, axis=0, initial=0)
    parabola = np.vander(t - t[0], 3)
    coefficients = np.linalg.lstsq(parabola[used], (x - displaced)[used])[0]
    errors: Floats = np.linalg.norm(x - displaced - parabola @ coefficients, axis=1)
    return errors
