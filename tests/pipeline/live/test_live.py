"""A camera server, rallygap live, a robot and a viewer: processes that talk by ZeroMQ and HTTP."""

import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
from functools import partial

import numpy as np
import pandas as pd
import pytest
import zmq
from typer.testing import CliRunner

from rallygap.models.predictors.ball_filter import ANY_BALL, Expected
from rallygap.pipeline.cli import app
from rallygap.pipeline.gap.expected_balls import expected_json
from rallygap.pipeline.live import command
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.live.example_frames import FIRST, PLACES, TIMES, TRUTH
from tests.services import await_answer, free_port

EXPECTED = Expected(0.002, (0.0, -120.0, 0.0), (40.0, 300.0, 90.0))
LIVE = ["live", "--simulator", "literature"]


def free_address():
    return f"tcp://127.0.0.1:{free_port()}"


def test_a_robot_and_a_viewer_get_forecasts_of_what_a_camera_server_measures():
    observations, forecasts, port = free_address(), free_address(), free_port()
    words = [*LIVE, "--observations", observations, "--forecasts", forecasts]
    words += ["--view", "--view-port", str(port)]
    hidden = {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"}
    known = {name: value for name, value in os.environ.items() if name not in hidden}
    live = subprocess.Popen(
        [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_IGN),  # as a job of a shell
        env=known,
    )
    context = zmq.Context()
    try:
        camera, robot = context.socket(zmq.PUB), context.socket(zmq.SUB)
        camera.bind(observations)
        robot.setsockopt(zmq.SUBSCRIBE, b"")
        robot.setsockopt(zmq.RCVTIMEO, 50)
        robot.connect(forecasts)
        last = until_forecast(camera, robot)
        await_answer(f"http://127.0.0.1:{port}/")
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/events", timeout=20) as events:
            picture = next(line for line in events if line.startswith(b"data: "))
            live.send_signal(signal.SIGINT)
            out, err = live.communicate(timeout=20)
    finally:
        live.kill()
        context.destroy(linger=0)
    assert last["seen"] == "used"
    assert np.array(last["states"])[9, :3] == pytest.approx(
        TRUTH.fly(FIRST, [last["time"] / 1e9 + 0.1]).states[0, 0, :3], abs=0.02
    )
    assert "num" in json.loads(picture.removeprefix(b"data: "))["forecast"]
    assert live.returncode == 0
    assert len(err.splitlines()) == err.count("such messages are left out") <= 1
    assert f"The view is at http://127.0.0.1:{port}/" in out and "p99" in out


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


@pytest.mark.parametrize("stop", command.STOPS)
def test_the_end_of_a_service_stops_forecasts_as_ctrl_c_does(stop):
    before = signal.getsignal(stop)
    with pytest.raises(KeyboardInterrupt), command._stoppable():
        os.kill(os.getpid(), stop)
        time.sleep(5.0)
    assert signal.getsignal(stop) == before


def test_recordings_are_replayed_and_latencies_shown(tmp_path):
    for k in range(2):
        table = pd.DataFrame(np.column_stack([TIMES, PLACES]), columns=["t", "x", "y", "z"])
        table.to_csv(tmp_path / f"ball_{k}.csv", index=False)
    words = [*LIVE, "--replay", str(tmp_path), "--speed", "1000"]
    result = CliRunner().invoke(app, [*words, "--forecasts", free_address()])
    assert result.exit_code == 0, result.output
    assert "120 frames" in result.output


def test_expected_balls_are_those_of_a_file(tmp_path):
    (tmp_path / "balls.json").write_text(expected_json(EXPECTED))
    found = command.forecaster("literature", None, tmp_path / "balls.json")
    assert found.expected == EXPECTED
    assert command.forecaster("literature", None, None).expected == ANY_BALL


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--observations", "nowhere"], "--observations, nowhere: cannot be used"),
        (["--forecasts", "nowhere"], "--forecasts, nowhere: cannot be used"),
    ],
)
def test_an_address_that_is_none_is_one_line(words, problem):
    free = [] if "--forecasts" in words else ["--forecasts", free_address()]
    result = CliRunner().invoke(app, [*LIVE, *words, *free])
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith(problem)
