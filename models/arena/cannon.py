"""A ball cannon over the far end line that shoots towards the robot, over a grid of settings."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from models.ball.contact import TABLE
from models.ball.simulator import Simulator
from models.ball.state import POSITION, SPIN, STATE_SIZE, TABLE_HALF_LENGTH, VELOCITY

Floats = NDArray[np.float64]

MUZZLE = (0.0, TABLE_HALF_LENGTH + 0.1, 0.30)  # m
YAW = (-8.0, -4.0, 0.0, 4.0, 8.0)  # degrees, positive to +x
PITCH = (-2.0, 3.0, 8.0, 14.0)  # degrees, positive upwards
SPEED = (4.0, 5.0, 6.5, 8.0)  # m/s
TOPSPIN = (-200.0, 0.0, 200.0, 350.0)  # rad/s, negative is backspin
SIDESPIN = (-150.0, 0.0, 150.0)  # rad/s about the vertical

# What a cannon sets is not quite what it does; standard deviations.
ANGLE_SPREAD = 0.3  # degrees
SPEED_SPREAD = 0.02  # share
SPIN_SPREAD = 0.03  # share

FEWEST_LANDING = 0.02  # share of the grid
LANDING_TIME = np.arange(0.0, 1.2, 0.005)  # s, in which every shot of the grid lands


def cannon_launches(simulator: Simulator, shots: int, random: np.random.Generator) -> Floats:
    """Return the (shots, 9) launch states of a session.

    The session goes through the grid in random order, again and again until it has enough shots.
    Shots whose ball does not land on the near half of the table are not part of it.

    Raises:
        ValueError: hardly any shot of the grid lands in this simulator.
    """
    grid = np.array(list(product(YAW, PITCH, SPEED, TOPSPIN, SIDESPIN)))
    session = np.empty((0, STATE_SIZE))
    while len(session) < shots:
        launches = launch_states(_scattered(random.permutation(grid), random))
        landed = launches[_lands(simulator, launches)]
        if len(landed) < FEWEST_LANDING * len(grid):
            raise ValueError("hardly any shot of the cannon lands on the table in this simulator")
        session = np.concatenate([session, landed])
    return session[:shots]


def launch_states(settings: Floats) -> Floats:
    """Return the (B, 9) launch states of cannon settings.

    Args:
        settings: (B, 5) yaw (degrees), pitch (degrees), speed (m/s), topspin and sidespin (rad/s).
    """
    yaw, pitch = np.radians(settings[:, 0]), np.radians(settings[:, 1])
    speed, topspin, sidespin = settings[:, 2:].T
    ahead = np.stack([np.sin(yaw), -np.cos(yaw), np.zeros_like(yaw)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    states = np.empty((len(settings), STATE_SIZE))
    states[:, POSITION] = MUZZLE
    states[:, VELOCITY] = speed[:, None] * (
        np.cos(pitch)[:, None] * ahead + np.sin(pitch)[:, None] * up
    )
    # Topspin turns the ball's upper side ahead: about the horizontal axis up x ahead.
    states[:, SPIN] = topspin[:, None] * np.cross(up, ahead) + sidespin[:, None] * up
    return states


def _lands(simulator: Simulator, states: Floats) -> NDArray[np.bool_]:
    """Return for each of (B, 9) launch states whether its first contact is the near half."""
    contacts = simulator.fly(states, LANDING_TIME).contacts
    on_table = (contacts.count > 0) & (contacts.surface[:, 0] == TABLE)
    landed: NDArray[np.bool_] = on_table & (contacts.before[:, 0, 1] < 0)
    return landed


def _scattered(settings: Floats, random: np.random.Generator) -> Floats:
    noise = random.standard_normal(settings.shape)
    scattered = settings.copy()
    scattered[:, :2] += ANGLE_SPREAD * noise[:, :2]
    scattered[:, 2] *= 1 + SPEED_SPREAD * noise[:, 2]
    scattered[:, 3:] *= 1 + SPIN_SPREAD * noise[:, 3:]
    return scattered
