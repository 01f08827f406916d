"""The forecaster: one measurement after the other comes in, forecasts are there at any time.

All times are of the sensor's clock, and all states as the sensor would measure them. A measurement
that the present ball cannot have made is an outlier, or belongs to another ball. It starts a second
track. If that goes on while the present ball is seen no more, a player has struck the ball, or
there is a new one, or the clock has started again: then the second track is the present ball.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.live import crossings
from rallygap.models.live.crossings import Crossing
from rallygap.models.live.track import Track, history_of
from rallygap.models.predictors.ball_filter import ANY_BALL, Expected
from rallygap.models.predictors.propagation import propagated
from rallygap.models.predictors.protocol import FUTURE_TIMES, TICK, ProbabilisticPredictor
from rallygap.models.predictors.sensor import Sensor

Seen = Literal["used", "unused", "new ball"]

NEW_BALL = 4  # measurements of another ball in a row, of which the present one has none
READY = 3  # measurements before a forecast
COMING = np.arange(201) * TICK  # s, how far ahead contacts, apex and crossings are looked for
NOT_MEASURED = np.full(3, np.nan)


@dataclass(frozen=True)
class Event:
    """Something that happens to a ball.

    Attributes:
        time: s, of the sensor's clock.
        time_error: s, its standard deviation.
        state: (9,) position (m), velocity (m/s) and spin (rad/s) then, before a contact, as they
            would be measured.
        covariance: (9, 9) of the state.
    """

    time: float
    time_error: float
    state: Floats
    covariance: Floats


class NoBallError(LookupError):
    """No ball has been measured often enough to forecast it."""


class Forecaster:
    """Forecasts the ball that is measured.

    ``bounce``, ``apex`` and ``crossing`` look 1 s ahead with a simulator, 0.3 s with a predictor.
    They raise ``ValueError`` where the predictor was compiled for some horizons alone.

    Args:
        simulator: of the ball and of the sensor; it tells which measurements belong to the ball.
        predictor: that forecasts up to 300 ms ahead, from the last 55 ms; the simulator does, from
            all measurements, if there is none.
        expected: of the balls; its noise is that of a position without a covariance.
    """

    def __init__(
        self,
        simulator: Simulator,
        predictor: ProbabilisticPredictor | None = None,
        expected: Expected = ANY_BALL,
    ) -> None:
        self.simulator, self.predictor, self.expected = simulator, predictor, expected
        self._sensor = Sensor(simulator)
        self._noise = expected.noise**2 * np.eye(3)
        self._ball = Track(simulator, expected)
        self._other = Track(simulator, expected)
        self._missed = 0  # measurements since the present ball had one
        self._forecast: Floats | None = None  # the predictor's, of this measurement

    @property
    def ready(self) -> bool:
        """Whether there is a ball to forecast."""
        return self._ball.count >= READY

    @property
    def ball(self) -> Track:
        """The track of the present ball."""
        return self._ball

    @property
    def last(self) -> float:
        """Time of the present ball's last measurement, s; minus infinity without a ball."""
        return self._ball.last

    def observe(
        self,
        t: float,
        position: ArrayLike,
        covariance: ArrayLike | None = None,
        spin: ArrayLike | None = None,
    ) -> Seen:
        """Take a measurement, in any order of times.

        Args:
            t: s, of the sensor's clock.
            position: (3,) m, in the table frame.
            covariance: (3, 3) m^2, of the position.
            spin: (3,) rad/s, if it was measured.

        Returns:
            Whether it was used for the present ball, or not, or has made another ball the present
            one.

        Raises:
            ValueError: a time or a position that is not finite, or a position without 3 numbers.
        """
        place = np.asarray(position, dtype=np.float64)
        if place.shape != (3,) or not np.isfinite(place).all() or not np.isfinite(t):
            raise ValueError(
                f"a measurement at {t} s has the position {position!r}; give 3 numbers"
            )
        noise = self._noise if covariance is None else np.asarray(covariance, dtype=np.float64)
        measured = NOT_MEASURED if spin is None else np.asarray(spin, dtype=np.float64)
        self._forecast = None
        if self._ball.add(t, place, noise, measured):
            self._missed = 0
            return "used"
        self._missed += 1
        if not self._other.add(t, place, noise, measured):
            self._other = Track(self.simulator, self.expected)
            self._other.add(t, place, noise, measured)
        if min(self._missed, self._other.count) < NEW_BALL:
            return "unused"
        self._ball, self._other = self._other, Track(self.simulator, self.expected)
        self._missed = 0
        return "new ball"

    def predict(self, times: ArrayLike) -> tuple[Floats, Floats]:
        """Forecast the ball.

        Args:
            times: (T,) s, of the sensor's clock, not falling.

        Returns:
            (T, 9) states: position (m), velocity (m/s) and spin (rad/s); and (T, 9, 9) covariances.
            Where a predictor forecasts, those of velocity and spin are the simulator's.

        Raises:
            NoBallError: there is no ball yet.
            ValueError: a time is farther ahead than the predictor forecasts, or is not one of those
                for which it was compiled.
        """
        if not self.ready:
            raise NoBallError("no ball has been measured three times yet")
        ahead = np.atleast_1d(np.asarray(times, dtype=np.float64)) - self._ball.last
        now = self._ball.state[None], self._ball.covariance[None]
        coming = propagated(self.simulator, *now, ahead / self._sensor.clock)
        states, covariances = (of_balls[0] for of_balls in coming)
        if self.predictor is None:
            return self._sensor.measured_states(states), covariances
        rows = _known(_at(ahead, self._by(self.predictor)))
        covariances[:, POSITION, 3:] = covariances[:, 3:, POSITION] = 0.0
        covariances[:, POSITION, POSITION] = rows[:, STATE_SIZE:].reshape(-1, 3, 3)
        return rows[:, :STATE_SIZE], covariances

    def bounce(self) -> Event | None:
        """Return the ball's next contact with the table; None without one in the forecast."""
        return self._event(crossings.bounce(self._coming(), self._sensor))

    def apex(self) -> Event | None:
        """Return where the ball next stops rising; None without one in the forecast."""
        return self._event(crossings.apex(self._coming(), TICK))

    def crossing(self, point: ArrayLike, normal: ArrayLike) -> Event | None:
        """Return where the ball next crosses a plane; None without one in the forecast.

        Args:
            point: (3,) m, of the plane, such as the middle of a robot's strike plane.
            normal: (3,) of the plane.
        """
        plane = np.asarray(point, dtype=np.float64), np.asarray(normal, dtype=np.float64)
        return self._event(crossings.plane(self._coming(), TICK, *plane))

    def _coming(self) -> Floats:
        """Return the forecast states, a tick apart; nothing without a ball."""
        if not self.ready:
            return np.empty((0, STATE_SIZE))
        if self.predictor is not None:
            return _known(self._by(self.predictor)[1:, :STATE_SIZE])
        states = self.simulator.fly(self._ball.state, COMING / self._sensor.clock).states[0]
        return self._sensor.measured_states(states)

    def _by(self, predictor: ProbabilisticPredictor) -> Floats:
        """Return (61, 18) states and covariances of positions, now and as a predictor says.

        It forecasts once a measurement.
        """
        if self._forecast is None:
            forecast, covariances = predictor.predict_with_covariances(history_of(self._ball))
            rows = np.empty((1 + len(FUTURE_TIMES), 2 * STATE_SIZE))
            rows[0, :STATE_SIZE] = self._sensor.measured_states(self._ball.state)
            rows[0, STATE_SIZE:] = self._ball.covariance[POSITION, POSITION].ravel()
            rows[1:, :STATE_SIZE] = forecast.states[0]
            rows[1:, STATE_SIZE:] = covariances[0].reshape(-1, STATE_SIZE)
            self._forecast = rows
        return self._forecast

    def _event(self, crossing: Crossing | None) -> Event | None:
        if crossing is None:
            return None
        first = TICK if self.predictor else 0.0  # of the coming states
        before = self._ball.last + first + COMING[crossing.row]
        covariance = self.predict([before])[1][0]
        time, error = float(before + crossing.after), crossing.time_error(covariance)
        return Event(time, error, crossing.state, covariance)


def _at(ahead: Floats, values: Floats) -> Floats:
    """Return (T, K) values between those of (61, K), now and at ``FUTURE_TIMES``."""
    if ahead.max() > FUTURE_TIMES[-1] + TICK / 100 or ahead.min() < 0.0:
        raise ValueError(f"a forecast of {1e3 * ahead.max():.0f} ms; give 0 to 300 ms")
    ticks = ahead / TICK
    after = np.minimum(np.maximum(np.ceil(ticks).astype(int), 1), len(FUTURE_TIMES))
    share = (ticks - after + 1)[:, None]
    return (1 - share) * values[after - 1] + share * values[after]


def _known(rows: Floats) -> Floats:
    """Return rows of forecasts, if the predictor was compiled for them."""
    if np.isnan(rows).any():
        raise ValueError("the predictor was not compiled for these horizons; compile it for more")
    return rows
