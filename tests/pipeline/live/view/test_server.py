"""The server of the view, asked by real clients."""

import json
import socket
import struct
import threading
import time
from contextlib import closing, contextmanager
from http.client import HTTPConnection
from itertools import cycle, islice

import pytest

from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.view import server as view
from rallygap.pipeline.live.view.server import served
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.live.view.example_frames import frames, rows
from tests.services import free_port

PATIENCE = 10  # s, for an answer


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


def test_events_bring_the_forecast(server, shown):
    with viewer(server) as events:
        server.show(shown[-1])
        picture = next_picture(events)
    assert picture["forecast"] == json.loads(shown[-1].message)


@pytest.mark.parametrize("path", ["/", "/events"])
@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:80", "", "localhost.:1"])
def test_another_host_is_refused(server, path, host):
    assert ask(server, path, host).status == 403


@pytest.mark.parametrize("host", ["localhost", "localhost:8080", "127.0.0.1"])
def test_a_tunnel_from_another_port_is_served(server, host):
    assert ask(server, "/", host).status == 200


def test_there_is_nothing_else(server):
    assert ask(server, "/../pyproject.toml").status == 404


def test_a_viewer_gets_the_latest_frame_and_none_before(server, shown):
    with viewer(server) as events:
        server.show(shown[0])
        assert next_picture(events)["forecast"]["num"] == 0
        for frame in shown:
            server.show(frame)
        assert next_picture(events)["forecast"]["num"] == 39


def test_pictures_come_no_faster_than_eyes_see(server, shown):
    ended = threading.Event()
    feeder = threading.Thread(target=feed, args=(server, shown, ended))
    with viewer(server) as events:
        start = time.monotonic()
        feeder.start()
        for _ in range(11):
            next_picture(events)
        took = time.monotonic() - start
        ended.set()
        feeder.join()
    assert took >= 10 / 30


def feed(server, shown, ended):
    """Show frames, a thousand a second."""
    k = 0
    while not ended.wait(0.001):
        k += 1
        server.show(shown[k % len(shown)])


def test_a_stalled_viewer_holds_nobody_up_and_is_left(server, shown, monkeypatch):
    monkeypatch.setattr(view._Viewer, "timeout", 1.0)
    waits = []
    with stalled(server) as client, viewer(server) as events:
        for frame in until_viewers(1, cycle(shown)):
            start = time.perf_counter()
            server.show(frame)
            waits.append(time.perf_counter() - start)
            next_picture(events)
        assert taken(client) < 300_000  # bytes: a second or two of pictures
    assert max(waits) < 0.5


def until_viewers(most, frames):
    """Yield frames until there are no more than ``most`` viewers."""
    deadline = time.monotonic() + 60
    while viewers() > most:
        assert time.monotonic() < deadline
        yield from islice(frames, 10)


def viewers():
    """How many threads serve a viewer."""
    return sum("process_request" in thread.name for thread in threading.enumerate())


def taken(client):
    """Read what is on its way to a client until the server's end; return how many bytes it was."""
    count = 0
    try:
        while part := client.recv(65536):
            count += len(part)
    except ConnectionResetError:
        pass
    return count


def test_a_viewer_that_goes_away_is_not_spoken_of(server, shown, capfd):
    with stalled(server) as client:
        time.sleep(0.1)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    with closing(socket.create_connection(server.server_address)) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
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


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_what_is_no_port_is_refused(port):
    with (
        pytest.raises(InputError, match=f"--view-port: {port} is no port"),
        served(port, Latencies()),
    ):
        pass


def test_a_port_that_is_taken_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        problem = f"--view-port: {port} cannot be had: Address already in use"
        with pytest.raises(InputError, match=problem), served(port, Latencies()):
            pass
