"""The loop: a measurement in, a forecast out, and how long that takes."""

import time
from collections.abc import Callable, Iterable

from rallygap.models.live.forecaster import Forecaster, Seen
from rallygap.pipeline.live.forecast import ball_forecast
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.messages import Measurement, forecast_message
from rallygap.pipeline.live.view.frame import Frame
from rallygap.pipeline.live.watch import Watch


def forecast_each(
    rows: Iterable[Measurement],
    forecaster: Forecaster,
    watch: Watch,
    publish: Callable[[str], object],
    latencies: Latencies,
    show: Callable[[Frame], object] | None = None,
) -> None:
    """Publish the forecast after each measurement.

    Args:
        rows: in the order in which they come.
        forecaster: that takes them.
        watch: for drift.
        publish: sends a message.
        latencies: counts how long each took.
        show: takes what a view shows, after the forecast is published; None without a view.
    """
    for row in rows:
        start = time.perf_counter()
        seen = _observe(forecaster, row)
        ball = ball_forecast(forecaster)
        message = forecast_message(row.number, seen, ball, watch.alarm)
        publish(message)
        latencies.add(time.perf_counter() - start)
        watch.observe(row, seen, forecaster.ball)
        if show is not None:
            measured = forecaster.ball.positions.copy()
            show(Frame(row.time, message, ball, measured, watch.alarm))


def warm_up(forecaster: Forecaster) -> None:
    """Compile what forecasts need, which takes seconds on a machine that has not done it yet."""
    other = Forecaster(forecaster.simulator, forecaster.predictor)
    for k in range(4):
        other.observe(0.005 * k, [0.0, 1.0 - 0.03 * k, 0.3], spin=[0.0, 0.0, 0.0])
        forecast_message(k, "used", ball_forecast(other))


def _observe(forecaster: Forecaster, row: Measurement) -> Seen:
    if row.position is None:
        return "unused"
    return forecaster.observe(row.time, row.position, spin=row.spin)
