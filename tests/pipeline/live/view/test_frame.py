"""The picture has the published forecast, and sets that contain the ball as often as they say."""

import json

import numpy as np
import pytest

from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.view.frame import picture
from tests.pipeline.live.view.example_frames import ALARM, PLACES, frames, rows


def pictures(measurements, alarm=None):
    latencies = Latencies()
    shown = frames(measurements, alarm, latencies)
    return shown, [json.loads(picture(frame, latencies)) for frame in shown]


def matrix(upper):
    xx, xy, xz, yy, yz, zz = upper
    return 1e-6 * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def test_a_picture_has_the_published_forecast_and_the_measured_path():
    shown, drawn = pictures(rows(40))
    assert drawn[-1]["forecast"] == json.loads(shown[-1].message)
    assert drawn[-1]["forecast"]["num"] == 39
    assert np.array(drawn[-1]["about"]["measured"]) == pytest.approx(PLACES[:40], abs=1e-4)
    assert drawn[-1]["about"]["frames"] == 40
    assert 0 < drawn[-1]["about"]["latency"]["50"] <= drawn[-1]["about"]["latency"]["99"]


@pytest.mark.parametrize("row", [0, 9, 29])
def test_a_set_contains_the_ball_with_90_percent_probability(row):
    shown, drawn = pictures(rows(40))
    covariance = shown[-1].ball.covariances[row]
    errors = np.random.default_rng(0).multivariate_normal(np.zeros(3), covariance, 20_000)
    inverse = np.linalg.inv(matrix(drawn[-1]["about"]["sets"][row]))
    inside = np.einsum("ni,ij,nj->n", errors, inverse, errors) <= 1
    assert inside.mean() == pytest.approx(0.9, abs=0.02)


def test_before_there_is_a_ball_nothing_of_it_is_shown():
    drawn = pictures(rows(2))[1]
    assert drawn[-1]["forecast"]["states"] is None
    assert drawn[-1]["about"]["sets"] == drawn[-1]["about"]["measured"] == []


def test_a_ball_is_shown_until_its_forecast_is_in_the_past():
    drawn = pictures(rows(40, lost=[0.3, 0.49, 0.5]))[1]
    assert [len(one["about"]["sets"]) for one in drawn[-3:]] == [30, 30, 0]
    assert drawn[-1]["forecast"]["seen"] == "unused"


def test_an_alarm_is_in_words():
    drawn = pictures(rows(4), ALARM)[1]
    assert "wind.x (the air moves) has changed by +0.31 m/s" in drawn[-1]["about"]["alarm"]
    assert pictures(rows(4))[1][-1]["about"]["alarm"] is None
