"""The view: what a picture shows, the server asked by real clients, and the start of a browser."""

import json
import socket
import struct
import threading
import time
import webbrowser
from contextlib import closing, contextmanager, suppress
from http.client import HTTPConnection
from itertools import cycle
from unittest.mock import Mock, call

import numpy as np
import pytest

from rallygap.pipeline.live import view
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.view import open_browser, picture, served
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.live.example_frames import ALARM, PLACES, frames, rows
from tests.services import free_port

PATIENCE = 10  # s, for an answer


def pictures(measurements, alarm=None):
    latencies = Latencies()
    shown = frames(measurements, alarm, latencies)
    return shown, [json.loads(picture(frame, latencies)) for frame in shown]


def test_a_picture_has_the_published_forecast_and_the_measured_path():
    shown, drawn = pictures(rows(40))
    forecast, about = drawn[-1]["forecast"], drawn[-1]["about"]
    assert forecast == json.loads(shown[-1].message)
    assert forecast["num"] == 39
    assert np.array(about["measured"]) == pytest.approx(PLACES[:40], abs=1e-4)
    assert about["frames"] == 40
    assert 0 < about["latency"]["50"] <= about["latency"]["99"]
    # Before there is a ball nothing of it is shown.
    assert drawn[1]["forecast"]["states"] is None
    assert drawn[1]["about"]["sets"] == drawn[1]["about"]["measured"] == []


def test_a_set_contains_the_ball_with_90_percent_probability():
    shown, drawn = pictures(rows(40))
    for row in (0, 9, 29):
        covariance = shown[-1].ball.covariances[row]
        errors = np.random.default_rng(0).multivariate_normal(np.zeros(3), covariance, 20_000)
        xx, xy, xz, yy, yz, zz = 1e-6 * np.array(drawn[-1]["about"]["sets"][row])
        inverse = np.linalg.inv([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        inside = np.einsum("ni,ij,nj->n", errors, inverse, errors) <= 1
        assert inside.mean() == pytest.approx(0.9, abs=0.02)


def test_a_ball_is_shown_until_its_forecast_is_in_the_past():
    drawn = pictures(rows(40, lost=[0.3, 0.49, 0.5]), ALARM)[1]
    assert [len(one["about"]["sets"]) for one in drawn[-3:]] == [30, 30, 0]
    assert drawn[-1]["forecast"]["seen"] == "unused"
    assert "wind.x (the air moves) has changed by +0.31 m/s" in drawn[-1]["about"]["alarm"]


@pytest.fixture(scope="module")
def shown():
    return frames(rows(40))


@pytest.fixture
def server():
    latencies = Latencies()
    latencies.add(0.001)
    with served(free_port(), latencies) as server:
        yield server


def ask(server, path, host=None):
    connection = HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    connection.request("GET", path, headers={} if host is None else {"Host": host})
    return connection.getresponse()


@contextmanager
def viewer(server):
    """The lines of the events that a viewer gets."""
    with closing(ask(server, "/events")) as response:
        assert response.getheader("Content-Type") == "text/event-stream"
        yield response


def next_picture(response):
    while True:
        line = response.readline()
        assert line, "the events have ended"
        if line.startswith(b"data: "):
            return json.loads(line.removeprefix(b"data: "))


@contextmanager
def stalled(server):
    """A client that asks for events and takes none."""
    with socket.socket() as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.connect(server.server_address)
        client.sendall(b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n")
        yield client


def test_the_page_is_served_on_this_machine_alone(server):
    answer = ask(server, "/")
    page = answer.read().decode()
    assert (answer.status, answer.getheader("Content-Type")) == (200, "text/html; charset=utf-8")
    assert "<canvas" in page and "EventSource" in page
    assert server.socket.getsockname()[0] == "127.0.0.1"
    assert server.address == f"http://127.0.0.1:{server.server_port}/"
    for host in ("localhost", "localhost:8080", "127.0.0.1"):  # a tunnel from another port
        assert ask(server, "/", host).status == 200
    for host in ("evil.example", "127.0.0.1.evil.example:80", "", "localhost.:1"):
        assert ask(server, "/", host).status == ask(server, "/events", host).status == 403
    assert ask(server, "/../pyproject.toml").status == 404


def test_a_viewer_gets_the_latest_frame_no_faster_than_eyes_see(server, shown):
    with viewer(server) as events:
        start = time.monotonic()
        for frame in shown[:6]:
            server.show(frame)
            assert next_picture(events)["forecast"] == json.loads(frame.message)
        assert time.monotonic() - start >= 5 / 30
        for frame in shown:
            server.show(frame)
        assert next_picture(events)["forecast"]["num"] == 39


def test_a_stalled_viewer_holds_nobody_up_and_is_left(server, shown, monkeypatch):
    monkeypatch.setattr(view._Viewer, "timeout", 1.0)
    waits, count, deadline = [], 0, time.monotonic() + 60
    with stalled(server) as client, viewer(server) as events:
        for frame in cycle(shown):
            start = time.perf_counter()
            server.show(frame)
            waits.append(time.perf_counter() - start)
            next_picture(events)
            assert time.monotonic() < deadline
            if sum("process_request" in thread.name for thread in threading.enumerate()) == 1:
                break
        with suppress(ConnectionResetError):  # what is on its way to the client
            while part := client.recv(65536):
                count += len(part)
    assert count < 300_000  # bytes: a second or two of pictures
    assert max(waits) < 0.5


def test_a_viewer_that_goes_away_is_not_spoken_of(server, shown, capfd):
    at_once = struct.pack("ii", 1, 0)
    with stalled(server) as client:
        time.sleep(0.1)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
    with closing(socket.create_connection(server.server_address)) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
    with viewer(server) as events:
        for frame in shown[:5]:
            server.show(frame)
            next_picture(events)
    assert capfd.readouterr() == ("", "")


def test_the_end_waits_for_no_viewer_and_tells_them(shown):
    with served(free_port(), Latencies()) as server, stalled(server), viewer(server) as events:
        server.ended.wait(0.1)
        start = time.monotonic()
        server.ended.set()
        server.shutdown()
        assert events.read().endswith(b"\n\n")
    assert time.monotonic() - start < 3


def test_a_port_that_is_none_or_taken_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        for number, problem in ((0, "is no port"), (65536, "is no port"), (port, "cannot be had")):
            problem = f"--view-port: {number} {problem}"
            with pytest.raises(InputError, match=problem), served(number, Latencies()):
                pass


@pytest.mark.parametrize(
    ("name", "error"),
    [("", None), ("DISPLAY", None), ("WAYLAND_DISPLAY", webbrowser.Error), ("BROWSER", OSError)],
)
def test_a_browser_is_opened_where_there_is_a_screen_or_a_named_one(
    monkeypatch, capfd, name, error
):
    opened = Mock(side_effect=error)
    monkeypatch.setattr(view.sys, "platform", "linux")
    monkeypatch.setattr(webbrowser, "open", opened)
    for screen in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(screen, raising=False)
    if name:
        monkeypatch.setenv(name, ":0")
    open_browser("http://127.0.0.1:7662/")
    for thread in threading.enumerate():
        if thread.name == view.OPENER:
            thread.join()
    assert opened.mock_calls == ([call("http://127.0.0.1:7662/")] if name else [])
    assert capfd.readouterr().err == ""
