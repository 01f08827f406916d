"""``rallygap live``: from a camera server or from recordings to forecasts."""

import signal
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path

import typer

from rallygap.models.live.forecaster import Forecaster, Seen
from rallygap.models.predictors.ball_filter import ANY_BALL
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.gap.expected_balls import read_expected
from rallygap.pipeline.gap.measured_shots import read_recordings
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.messages import (
    Measurement,
    alarm_sentence,
    ball_forecast,
    forecast_message,
    measurements,
    paced,
    received,
    sockets,
)
from rallygap.pipeline.live.view import Frame, open_browser, served
from rallygap.pipeline.live.watch import Watch
from rallygap.pipeline.runtime.console import warn

STOPS = (signal.SIGINT, signal.SIGTERM)


def forecaster(simulator: str, predictor: Path | None, balls: Path | None) -> Forecaster:
    """Return a forecaster that has compiled what it needs.

    Args:
        simulator: name of a shipped one, or its YAML file.
        predictor: folder of a trained one, if the simulator is not to forecast.
        balls: file of the balls to expect; without it they may have any spin.

    Raises:
        InputError: one of these cannot be read.
    """
    compiled: ProbabilisticPredictor | None = None
    if predictor is not None:
        from rallygap.models.live.compiled import CompiledPredictor
        from rallygap.pipeline.predictors.storage import load_predictor

        compiled = CompiledPredictor(load_predictor(predictor))
    expected = read_expected(balls) if balls else ANY_BALL
    ready = Forecaster(load_simulator(simulator), compiled, expected)
    # What forecasts need is compiled now: that takes seconds on a machine that has not done it yet.
    other = Forecaster(ready.simulator, ready.predictor)
    for k in range(4):
        other.observe(0.005 * k, [0.0, 1.0 - 0.03 * k, 0.3], spin=[0.0, 0.0, 0.0])
        forecast_message(k, "used", ball_forecast(other))
    return ready


def serve(
    forecaster: Forecaster, observations: str, forecasts: str, view: int | None = None
) -> Latencies:
    """Forecast what a camera server measures until Ctrl-C; return the latencies.

    Args:
        forecaster: of the ball.
        observations: address of the camera server.
        forecasts: address to publish at.
        view: port of a page that shows the ball; None for no page.

    Raises:
        InputError: an address or the port cannot be used.
    """
    with sockets(observations, forecasts) as (receiver, sender):
        return _run(received(receiver), forecaster, sender.send_string, view)


def replay(
    forecaster: Forecaster,
    folder: Path,
    source: str,
    speed: float,
    forecasts: str,
    view: int | None = None,
) -> Latencies:
    """Forecast what is in recordings, as if it came from cameras; return the latencies.

    Args:
        forecaster: of the ball.
        folder: of the recordings.
        source: name of the adapter that reads them.
        speed: how many times as fast as they were recorded.
        forecasts: address to publish at.
        view: port of a page that shows the ball; None for no page.

    Raises:
        InputError: the recordings, the address or the port cannot be used.
    """
    rows = measurements(read_recordings(folder, source).parts)
    with sockets(None, forecasts) as (_, sender):
        return _run(paced(rows, speed), forecaster, sender.send_string, view)


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
        seen: Seen = "unused"  # a frame without a ball
        if row.position is not None:
            seen = forecaster.observe(row.time, row.position, spin=row.spin)
        ball = ball_forecast(forecaster)
        message = forecast_message(row.number, seen, ball, watch.alarm)
        publish(message)
        latencies.add(time.perf_counter() - start)
        watch.observe(row, seen, forecaster.ball)
        if show is not None:
            measured = forecaster.ball.positions.copy()
            show(Frame(row.time, message, ball, measured, watch.alarm))


def _run(
    rows: Iterator[Measurement],
    forecaster: Forecaster,
    publish: Callable[[str], object],
    view: int | None,
) -> Latencies:
    latencies = Latencies()
    show: Callable[[Frame], object] | None = None
    with ExitStack() as stack:
        if view is not None:
            server = stack.enter_context(served(view, latencies))
            typer.echo(f"The view is at {server.address}")
            open_browser(server.address)
            show = server.show
        watch = Watch(forecaster.simulator, lambda alarm: warn(alarm_sentence(alarm)))
        stack.enter_context(closing(watch))
        stack.enter_context(_stoppable())
        with suppress(KeyboardInterrupt):
            forecast_each(rows, forecaster, watch, publish, latencies, show)
    return latencies


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let Ctrl-C and the end of a service stop the block, also where the shell ignores Ctrl-C."""
    before = {stop: signal.signal(stop, signal.default_int_handler) for stop in STOPS}
    try:
        yield
    finally:
        for stop, handler in before.items():
            signal.signal(stop, handler)
