"""Landings are where flights say, as a sensor sees them."""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.verify.landing import landings

FALLING = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.2}}
)
DROPPED = np.array([[0.1, 0.5, 0.52, 0.2, -1.0, 0.0, 0.0, 0.0, 0.0]])
FALL = np.sqrt(2 * 0.5 / 9.81)  # s


def test_a_ball_without_air_lands_where_the_closed_form_says():
    found = landings(FALLING, DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [FALL], rtol=1e-9)
    np.testing.assert_allclose(found.places, [[0.1 + 0.2 * FALL, 0.5 - FALL]], rtol=1e-9)


def test_landings_have_the_errors_of_the_sensor():
    sensor = FALLING.amended("clock_rate", d=0.01).amended("position_scale", s=0.02)
    found = landings(sensor.amended("time_offset", tau=0.004), DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [1.01 * (FALL + 0.004)], rtol=1e-9)
    np.testing.assert_allclose(found.places, [[1.02 * (0.1 + 0.2 * FALL), 1.02 * (0.5 - FALL)]])
    speed = np.linalg.norm([0.2, -1.0, 9.81 * FALL])
    with_speed = FALLING.amended("speed_dependent_latency", tau=0.001)
    found = landings(with_speed, DROPPED, np.array([1.0]))
    np.testing.assert_allclose(found.times, [FALL + 0.001 * speed], rtol=1e-9)


def test_a_ball_that_has_not_landed_in_time_has_no_landing():
    found = landings(FALLING, np.repeat(DROPPED, 2, axis=0), np.array([FALL / 2, 1.0]))
    assert np.isnan(found.times).tolist() == [True, False]
