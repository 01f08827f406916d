"""The cameras err as a smooth function of place, as after a calibration."""

from typing import Any

import numpy as np

from rallygap.models.ball.camera_field import weighted_covariances
from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View
from rallygap.models.ball.types import Floats

effect = Effect(
    name="camera_distortion",
    title="the cameras err as a smooth function of place",
    equation="x_measured = x + s sum_j k(|x - x_j|) w_j, k(d) = exp(-d^2 / 2 l^2)",
    acts="sensor",
    parameters=(
        Parameter("amplitude", unit="m", bounds=(0.0, 0.05), observed="1-4 mm; 25 mm in one set"),
        Parameter("length", unit="m", neutral=0.8, bounds=(0.1, 10.0), observed="0.6-2 m"),
    ),
    table=("x", "y", "z", "wx", "wy", "wz"),
)


@effect.adds("position_error")
def position_error(view: View, amplitude: float, length: float, nodes: Any) -> Floats:
    places, rows = np.asarray(view.place), np.asarray(nodes, dtype=np.float64).reshape(-1, 6)
    sums = weighted_covariances(places.reshape(-1, 3), rows[:, :3], rows[:, 3:], length)
    return amplitude * sums.reshape(places.shape)
