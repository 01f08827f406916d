"""What the view shows of a frame, and the picture that the page draws of it."""

import json
from dataclasses import dataclass
from typing import Any

from scipy.special import chdtri

from rallygap.models.ball.types import Floats
from rallygap.models.live.drift import Alarm
from rallygap.models.live.track import LONGEST_GAP
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.messages import BallForecast
from rallygap.pipeline.live.watch import alarm_sentence

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
    seen = _seen(frame)
    about = {
        "measured": frame.measured.round(4).tolist() if seen else [],
        "sets": _sets(seen.covariances) if seen else [],
        "latency": {share: latencies.percentile(share) for share in (50, 99)},
        "frames": latencies.frames,
        "alarm": alarm_sentence(frame.alarm) if frame.alarm else None,
    }
    return f'{{"forecast": {frame.message}, "about": {json.dumps(about)}}}'


def _seen(frame: Frame) -> BallForecast | None:
    """Return the forecast of a ball that was measured recently."""
    ball = frame.ball
    return None if ball is None or frame.time - ball.time > LONGEST_GAP else ball


def _sets(covariances: Floats) -> list[Any]:
    rows, columns = UPPER
    matrices: list[Any] = (MM2 * SQUARED_RADIUS * covariances[:, rows, columns]).round(2).tolist()
    return matrices
