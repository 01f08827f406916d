"""Balls on their way, each at its own tick."""

import numpy as np

from models.policy.balls_in_flight import PATH_STEPS_PER_CONTROL, BallsInFlight
from models.policy.incoming_balls import FIRST_WINDOW, IncomingBalls, control_times


def numbered(count, start=0.0, playable=(0.3, 0.9)):
    """Return balls whose height is the millisecond, and whose forecasts say the tick."""
    path = np.zeros((count, 1701, 9))
    path[..., 2] = np.arange(1701)
    forecasts = np.zeros((count, len(control_times(start)), 3, 9))
    forecasts += np.arange(forecasts.shape[1])[:, None, None]
    return IncomingBalls(path, np.tile(playable, (count, 1)), start, forecasts)


def test_a_tick_shows_the_path_and_the_forecasts_of_its_time():
    balls = BallsInFlight(numbered(2))
    balls.advance()

    moments, states = balls.ahead()

    np.testing.assert_array_equal(moments[:, 1], 40 + np.arange(PATH_STEPS_PER_CONTROL + 1))
    np.testing.assert_array_equal(states[..., 2], moments)
    assert (balls.forecasts == 1).all()


def test_the_first_tick_waits_for_the_first_window():
    moments, states = BallsInFlight(numbered(1, start=FIRST_WINDOW)).ahead()

    assert moments[0, 0] == 55
    assert states[0, 0, 2] == 55


def test_balls_are_replaced_one_by_one():
    balls = BallsInFlight(numbered(3))
    balls.advance()
    balls.replace(np.array([False, True, False]), numbered(1, playable=(0.2, 0.5)))

    assert balls.first.tolist() == [40, 0, 40]
    assert balls.forecasts[:, 0, 0].tolist() == [1, 0, 1]
    np.testing.assert_allclose(balls.bounce, [300, 200, 300])
    np.testing.assert_allclose(balls.gone, [900, 500, 900])


def test_after_its_last_tick_a_ball_stays_where_it_was():
    balls = BallsInFlight(numbered(1))
    for _ in range(60):
        balls.advance()

    assert (balls.ahead()[1][..., 2] == 1700).all()
    assert (balls.forecasts == len(control_times(0.0)) - 1).all()
