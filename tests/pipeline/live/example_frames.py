"""A ball that is thrown, its measurements, and frames as the loop hands them to the view."""

from unittest.mock import Mock

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.live.drift import Alarm
from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.live.command import forecast_each
from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.messages import Measurement

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
TIMES = 0.005 * np.arange(60)
PLACES = TRUTH.fly(FIRST, TIMES).states[0, :, :3]
ALARM = Alarm(
    Hypothesis("wind", "x"),
    change=0.31,
    error=0.04,
    shots=14,
    possible=(Hypothesis("wind", "x"), Hypothesis("frame_tilt", "x")),
)


def rows(count=40, lost=()):
    """Measurements of one ball; frames after them without a ball, at these times."""
    for k in range(count):
        yield Measurement(k, TIMES[k], PLACES[k])
    for k, t in enumerate(lost):
        yield Measurement(count + k, t, None)


def frames(measurements, alarm=None, latencies=None):
    """What the loop shows of measurements."""
    shown = []
    forecast_each(
        measurements,
        Forecaster(TRUTH),
        Mock(alarm=alarm),
        lambda message: None,
        latencies or Latencies(),
        shown.append,
    )
    return shown
