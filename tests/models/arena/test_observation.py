"""Observation: frames at multiples of the interval, of nothing but the ball."""

import numpy as np
import pytest

from rallygap.models.arena.cameras import Cameras, SlowError
from rallygap.models.arena.contacts import follow_contacts
from rallygap.models.arena.observation import TrackedBall, observe
from rallygap.models.arena.recording import TrueContacts
from tests.models.arena.sessions import TRUTH, flying

CAMERAS = Cameras(0.003, 0.05, 0.02, 0.01, SlowError(0.3, 0.05), interval=0.005)


def balls(count, random):
    """Return balls that start at the extremes of the game, until their second contact."""
    launches = flying(count, random)
    flight = follow_contacts(TRUTH, launches, 1, random)
    return [
        TrackedBall(
            TrueContacts(np.array([0.001]), np.array(["launch"]), launches[None, row]), 0.001 + end
        )
        for row, end in enumerate(np.minimum(flight.times[:, 0], flight.last_visible))
    ]


def test_frames_lie_on_the_grid_between_launch_and_end():
    seen = balls(20, np.random.default_rng(0))
    measured = observe(TRUTH, CAMERAS, seen, np.random.default_rng(1))
    for ball, (times, _, _) in zip(seen, measured, strict=True):
        steps = times / 0.005
        assert steps == pytest.approx(np.round(steps))
        assert (times >= 0.001).all()
        assert (times <= ball.last_visible).all()
