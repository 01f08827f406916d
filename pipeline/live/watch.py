"""The watch for drift during forecasts: shots go to another process, alarms come back."""

import signal
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.live.drift import Alarm, Session, Shot
from rallygap.models.live.forecaster import Seen
from rallygap.models.live.track import Track
from rallygap.pipeline.live.messages import Measurement

LEAST = 20  # measurements of a shot
Row = tuple[float, np.ndarray, np.ndarray]  # time, position and spin
NO_SPIN = np.full(3, np.nan)


class Watch:
    """Watches for drift in a process of its own, so that forecasts do not wait for it.

    Args:
        simulator: of the ball.
        on_alarm: called with the first alarm.

    Attributes:
        alarm: the first one, None until then.
    """

    def __init__(self, simulator: Simulator, on_alarm: Callable[[Alarm], None]) -> None:
        self.alarm: Alarm | None = None
        self._on_alarm = on_alarm
        self._rows: list[Row] = []  # of the present ball, in the order in which they came
        self._pending: deque[Future[Alarm | None]] = deque()
        self._worker = ProcessPoolExecutor(
            1, get_context("spawn"), initializer=partial(_start, simulator)
        )

    def observe(self, row: Measurement, seen: Seen, ball: Track) -> None:
        """Take a measurement and what became of it, and look whether there is an alarm.

        The first alarm ends the watch: the simulator has to be amended.
        """
        if self.alarm:
            return
        if seen == "new ball":
            if len(self._rows) >= LEAST:
                in_order = sorted(self._rows, key=lambda sample: sample[0])
                times, positions, spins = map(np.array, zip(*in_order, strict=True))
                self._pending.append(self._worker.submit(_add, (times, positions, spins)))
            first = zip(ball.times, ball.positions.copy(), ball.spins.copy(), strict=True)
            self._rows = list(first)
        elif seen == "used" and row.position is not None:
            self._rows.append((row.time, row.position, NO_SPIN if row.spin is None else row.spin))
        while self._pending and self._pending[0].done():
            self.alarm = self._pending.popleft().result()
            if self.alarm:
                self._on_alarm(self.alarm)
                return

    def close(self) -> None:
        """End the process."""
        self._worker.shutdown(wait=False, cancel_futures=True)


_session: Session  # of the worker


def _start(simulator: Simulator) -> None:
    global _session
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the terminal's processes alike
    _session = Session(simulator)


def _add(shot: Shot) -> Alarm | None:
    return _session.add(shot)
