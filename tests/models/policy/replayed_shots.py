"""Replayed shots for the tests: flown by the literature's simulator, measured as asked."""

import numpy as np

from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.replay.shots import Shot
from tests.models.predictors.balls import TRUTH
from tests.models.predictors.episodes import flown

# A stroke, and a serve that bounces on either half; both come to the robot.
STROKE = np.array([0.1, 1.3, 0.3, 0.2, -6.5, 1.0, -100.0, 10.0, 5.0])
SERVE = np.array([0.0, 1.5, 0.3, 0.1, -4.5, -1.0, 50.0, 0.0, 0.0])


def sampled(first=STROKE, until=0.7, rate=200.0, **noise):
    """The episode of a ball that is measured from its launch on, evenly."""
    return flown(first, np.arange(int(until * rate + 1e-6) + 1) / rate, **noise)


def shot(measured=None, first=STROKE, known=300):
    """A ball whose true states are known for so many milliseconds."""
    flight = TRUTH.fly(first, PATH_TIMES[:known])
    bounces = flight.contacts.time[0][: flight.contacts.count[0]]
    return Shot(sampled(first) if measured is None else measured, flight.states[0], bounces)
