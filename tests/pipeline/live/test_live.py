"""A camera server, rallygap live and a robot: three processes that talk by ZeroMQ."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request

import numpy as np
import pandas as pd
import pytest
import zmq
from typer.testing import CliRunner

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.ball_filter import ANY_BALL, Expected
from rallygap.pipeline.cli import app
from rallygap.pipeline.gap.expected_balls import expected_json
from rallygap.pipeline.live.command import forecaster
from rallygap.pipeline.live.streams import measurements, paced
from rallygap.pipeline.runtime.errors import InputError
from tests.services import await_answer, free_port

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
TIMES = 0.005 * np.arange(60)
EXPECTED = Expected(0.002, (0.0, -120.0, 0.0), (40.0, 300.0, 90.0))
PLACES = TRUTH.fly(FIRST, TIMES).states[0, :, :3]


def free_addresses(count):
    taken = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    addresses = [f"tcp://127.0.0.1:{one.getsockname()[1]}" for one in taken]
    for one in taken:
        one.close()
    return addresses


@pytest.fixture
def recordings(tmp_path):
    for k in range(2):
        table = pd.DataFrame(np.column_stack([TIMES, PLACES]), columns=["t", "x", "y", "z"])
        table.to_csv(tmp_path / f"ball_{k}.csv", index=False)
    return tmp_path


def ignoring_interrupts():
    """As a shell starts a job in the background."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_robot_gets_forecasts_of_what_a_camera_server_measures(stop):
    observations, forecasts = free_addresses(2)
    command = [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()", "live"]
    command += ["--simulator", "literature", "--observations", observations]
    live = subprocess.Popen(
        [*command, "--forecasts", forecasts],
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=ignoring_interrupts,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    context = zmq.Context()
    try:
        camera, robot = context.socket(zmq.PUB), context.socket(zmq.SUB)
        camera.bind(observations)
        robot.setsockopt(zmq.SUBSCRIBE, b"")
        robot.setsockopt(zmq.RCVTIMEO, 50)
        robot.connect(forecasts)
        last = until_forecast(camera, robot)
        assert last["seen"] == "used"
        assert np.array(last["states"])[9, :3] == pytest.approx(
            TRUTH.fly(FIRST, [last["time"] / 1e9 + 0.1]).states[0, 0, :3], abs=0.02
        )
    finally:
        context.destroy(linger=0)
        live.send_signal(stop)
        out = live.communicate(timeout=20)[0]
    assert live.returncode == 0
    assert "p99" in out


def until_forecast(camera, robot):
    """Send measurements of one ball again and again, and return the first late forecast."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        camera.send_string("no measurement")
        for number, (t, place) in enumerate(zip(TIMES, PLACES, strict=True)):
            frame = {"num": number, "time": round(t * 1e9), "proc_time": 1, "obs": place.tolist()}
            camera.send_string(json.dumps(frame))
            try:
                answer = json.loads(robot.recv())
            except zmq.Again:
                continue
            if answer["num"] > 40 and answer["states"]:
                return answer
    raise AssertionError("no forecast came")


def test_recordings_are_replayed_and_latencies_shown(recordings):
    arguments = ["live", "--simulator", "literature", "--replay", str(recordings)]
    address = free_addresses(1)[0]
    result = CliRunner().invoke(app, [*arguments, "--speed", "1000", "--forecasts", address])
    assert result.exit_code == 0, result.output
    assert "120 frames" in result.output


def test_expected_balls_are_those_of_a_file(tmp_path):
    (tmp_path / "balls.json").write_text(expected_json(EXPECTED))
    assert forecaster("literature", None, tmp_path / "balls.json").expected == EXPECTED
    assert forecaster("literature", None, None).expected == ANY_BALL


def test_the_view_has_what_is_replayed_until_the_end(recordings):
    port, address = free_port(), free_addresses(1)[0]
    command = [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()", "live"]
    command += ["--simulator", "literature", "--replay", str(recordings), "--speed", "0.01"]
    command += ["--forecasts", address, "--view", "--view-port", str(port)]
    hidden = {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"}
    live = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={name: value for name, value in os.environ.items() if name not in hidden},
    )
    try:
        await_answer(f"http://127.0.0.1:{port}/")
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/events", timeout=20) as events:
            picture = next(line for line in events if b'"states": [[' in line)
            live.send_signal(signal.SIGINT)
            out, err = live.communicate(timeout=20)
    finally:
        live.kill()
    assert json.loads(picture.removeprefix(b"data: "))["forecast"]["seen"] == "used"
    assert (live.returncode, err) == (0, "")
    assert f"The view is at http://127.0.0.1:{port}/" in out and "p99" in out


def test_a_port_of_the_view_that_is_none_is_one_line(recordings):
    arguments = ["live", "--simulator", "literature", "--replay", str(recordings)]
    arguments += ["--forecasts", free_addresses(1)[0], "--view", "--view-port", "0"]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    assert str(result.exception) == "--view-port: 0 is no port; give one from 1 to 65535"


@pytest.mark.parametrize("option", ["--observations", "--forecasts"])
def test_an_address_that_is_none_is_one_line(option):
    result = CliRunner().invoke(app, ["live", "--simulator", "literature", option, "nowhere"])
    assert result.exit_code != 0
    assert f"{option}" in str(result.exception)


def test_recordings_follow_one_another_on_one_clock():
    rows = pd.DataFrame(
        {"recording_id": ["a", "a", "b"], "t": [5.0, 5.1, 3.0], "px": 0.0, "py": 0.0, "pz": 0.3}
    ).assign(wx=[np.nan, 1.0, 2.0], wy=1.0, wz=1.0)
    found = list(measurements([rows]))
    assert [one.time for one in found] == pytest.approx([0.0, 0.1, 1.1])
    assert [one.spin is None for one in found] == [True, False, False]


def test_the_speed_shortens_the_waits():
    rows = [type("Row", (), {"time": t})() for t in (0.0, 1.0, 2.0)]
    start = time.monotonic()
    assert list(paced(rows, 20.0)) == rows
    assert time.monotonic() - start >= 0.1
