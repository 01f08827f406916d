"""The view of live forecasts: a page of this machine that shows the ball in 3-D, and its server.

The loop hands each frame over by one assignment. Every viewer has a thread, which looks for the
latest frame when the next picture is due. Frames in between are not shown, and none waits.
"""

import json
import os
import re
import socket
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Event, Thread
from typing import Any

from scipy.special import chdtri

from rallygap.models.ball.types import Floats
from rallygap.models.live.drift import Alarm
from rallygap.models.live.track import LONGEST_GAP
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.messages import BallForecast, alarm_sentence
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.environment import page_environment, table_geometry

TEMPLATES = Path(__file__).parent / "templates"
HOST = "127.0.0.1"
# Any other name may belong to a web site that lets it point here, to read the page (DNS rebinding).
LOCAL = re.compile(r"(127\.0\.0\.1|localhost)(:\d+)?")
INTERVAL = 1 / 30  # s between pictures
PATIENCE = 5.0  # s, after which a viewer that takes nothing is dropped
QUIET = 60  # intervals without a frame, after which a comment shows whether the viewer is there
UNDERWAY = 1 << 16  # bytes of pictures on their way to a viewer; more would be old on arrival
POLL = 0.1  # s, after which the server looks whether it is to end
RETRY = b"retry: 1000\n\n"  # ms, after which the page connects again
COMMENT = b":\n\n"
WITHOUT_X = ("darwin", "win32")  # platforms whose screen no variable tells
OPENER = "browser opener"  # name of the thread
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")

OUTSIDE = 0.1  # probability that a position is outside of its set
# Squared Mahalanobis radius of the set, for normally distributed errors in three dimensions.
SQUARED_RADIUS = float(chdtri(3, OUTSIDE))
UPPER = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])  # rows and columns of a symmetric matrix
MM2 = 1e6  # in a m^2


@dataclass(frozen=True)
class Frame:
    """What is known after a frame.

    Attributes:
        time: s, of the frame, on the sensor's clock.
        message: the forecast as it is published, JSON.
        ball: the forecast in numbers; None without a ball.
        measured: (K, 3) m, the ball's latest positions, in the order of their times.
        alarm: of the watch for drift; None without any.
    """

    time: float
    message: str
    ball: BallForecast | None
    measured: Floats
    alarm: Alarm | None


def picture(frame: Frame, latencies: Latencies) -> str:
    """Return what the page draws, one line of JSON: the forecast, and what the message lacks.

    Its ``sets`` are ellipsoids about the forecast positions that contain the ball with 90 %
    probability. Each is the upper triangle of a symmetric matrix M, mm^2: the points x with
    x' M^-1 x <= 1. ``measured`` is empty once the ball has not been measured for so long that its
    whole forecast is in the past.

    Args:
        frame: the latest.
        latencies: of the frames up to now.
    """
    seen = frame.ball
    if seen is not None and frame.time - seen.time > LONGEST_GAP:
        seen = None
    sets: list[Any] = []
    if seen is not None:
        rows, columns = UPPER
        sets = (MM2 * SQUARED_RADIUS * seen.covariances[:, rows, columns]).round(2).tolist()
    about = {
        "measured": [] if seen is None else frame.measured.round(4).tolist(),
        "sets": sets,
        "latency": {share: latencies.percentile(share) for share in (50, 99)},
        "frames": latencies.frames,
        "alarm": alarm_sentence(frame.alarm) if frame.alarm else None,
    }
    return f'{{"forecast": {frame.message}, "about": {json.dumps(about)}}}'


class ViewServer(ThreadingHTTPServer):
    """Serves the page and its events.

    Args:
        port: of this machine.
        latencies: of the frames, shown with them.

    Attributes:
        page: UTF-8; it works offline but for the events of this server.
        ended: whether all viewers are to be dropped.

    Raises:
        OSError: the port cannot be had.
    """

    daemon_threads = True  # the end does not wait for a viewer that has stalled

    def __init__(self, port: int, latencies: Latencies) -> None:
        template = page_environment(TEMPLATES).get_template("live.html")
        self.page = template.render(view={"table": table_geometry()}).encode()
        self.ended = Event()
        self._latencies = latencies
        self._latest: Frame | None = None
        super().__init__((HOST, port), _Viewer)

    @property
    def address(self) -> str:
        """Of the page."""
        return f"http://{HOST}:{self.server_port}/"

    def show(self, frame: Frame) -> None:
        """Take the latest frame; the one before is forgotten."""
        self._latest = frame

    def events(self) -> Iterator[bytes]:
        """Yield pictures as server-sent events until the end; the latest frame when one is due."""
        yield RETRY
        shown, quiet = None, 0
        while not self.ended.wait(INTERVAL):
            frame, quiet = self._latest, quiet + 1
            if frame is not None and frame is not shown:
                yield f"data: {picture(frame, self._latencies)}\n\n".encode()
                shown, quiet = frame, 0
            elif quiet >= QUIET:
                yield COMMENT
                quiet = 0

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a viewer that has gone."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


@contextmanager
def served(port: int, latencies: Latencies) -> Iterator[ViewServer]:
    """Serve the view at a port of this machine, with latencies, during the block.

    Raises:
        InputError: the port cannot be had.
    """
    if not 0 < port < 1 << 16:
        raise InputError("--view-port", f"{port} is no port; give one from 1 to 65535")
    try:
        server = ViewServer(port, latencies)
    except OSError as error:
        problem = f"{port} cannot be had: {os.strerror(error.errno or 0)}; give another one"
        raise InputError("--view-port", problem) from None
    with server:
        Thread(target=server.serve_forever, args=(POLL,), daemon=True).start()
        try:
            yield server
        finally:
            server.ended.set()
            server.shutdown()


def open_browser(address: str) -> None:
    """Open a page in the browser, if there is a screen or the user has named a browser.

    Elsewhere, ``webbrowser`` would start a browser of text, which takes the terminal. A browser
    that is slow to start is not waited for, and one that does not start is no error.
    """

    def open_page() -> None:
        with suppress(webbrowser.Error, OSError):
            webbrowser.open(address)

    if sys.platform in WITHOUT_X or any(os.environ.get(name) for name in SCREENS):
        Thread(target=open_page, name=OPENER, daemon=True).start()


class _Viewer(BaseHTTPRequestHandler):
    """Answers one request."""

    server: ViewServer
    timeout = PATIENCE

    def do_GET(self) -> None:
        """Send the page, or pictures as long as the viewer takes them."""
        if not LOCAL.fullmatch(self.headers.get("Host", "")):
            self.send_error(HTTPStatus.FORBIDDEN, "This page is for this machine alone")
        elif self.path == "/":
            self._start("text/html; charset=utf-8")
            self.wfile.write(self.server.page)
        elif self.path == "/events":
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNDERWAY)
            self._start("text/event-stream")
            with suppress(OSError):  # the viewer has gone, or takes nothing
                for event in self.server.events():
                    self.wfile.write(event)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def _start(self, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: the terminal is for forecasts."""
