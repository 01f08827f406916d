"""Observation: frames at multiples of the interval, of nothing but the ball."""

import numpy as np
import pytest

from models.arena.cameras import Cameras, SlowError
from models.arena.contacts import follow_contacts
from models.arena.observation import TrackedBall, observe
from models.arena.recording import TrueContacts
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
    for ball, samples in zip(
        seen, observe(TRUTH, CAMERAS, seen, np.random.default_rng(1)), strict=True
    ):
        steps = samples.times / 0.005
        assert steps == pytest.approx(np.round(steps))
        assert (samples.times >= 0.001).all()
        assert (samples.times <= ball.last_visible).all()


def test_balls_of_35_metres_a_second_and_1000_radians_a_second_are_measured():
    random = np.random.default_rng(3)
    launches = flying(300, random)
    launches[:, 3:6] *= 35 / np.linalg.norm(launches[:, 3:6], axis=1, keepdims=True)
    launches[:, 6:] *= 1000 / np.linalg.norm(launches[:, 6:], axis=1, keepdims=True)
    flight = follow_contacts(TRUTH, launches, 3, random)

    for row in np.flatnonzero(np.isfinite(flight.times[:, 0])):
        met = np.isfinite(flight.times[row])
        contacts = TrueContacts(
            flight.times[row, met], flight.surfaces[row, met], flight.states[row, met]
        )
        (samples,) = observe(
            TRUTH, CAMERAS, [TrackedBall(contacts, flight.last_visible[row])], random
        )
        assert np.isfinite(samples.positions).all()
        assert np.isfinite(samples.spins).all()
