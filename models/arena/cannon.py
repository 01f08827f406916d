"""A ball cannon on the far side that shoots to the near one, over a grid of settings."""

import numpy as np

from rallygap.models.arena.contacts import KINDS, follow_contacts
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import TrackedBall
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Floats

MUZZLE_ACROSS = (-0.5, 0.0, 0.5)  # m
MUZZLE_ALONG = (1.3, 2.0)  # m
MUZZLE_HEIGHT = (0.25, 0.45)  # m
YAW = (-12.0, -6.0, 0.0, 6.0, 12.0)  # degrees, positive to +x
PITCH = tuple(np.arange(-8.0, 31.0, 3.0))  # degrees, positive upwards
SPEED = (4.0, 5.0, 6.5, 8.0, 10.0, 12.5, 15.0, 18.0)  # m/s
TOPSPIN = (-300.0, -150.0, 0.0, 150.0, 300.0, 500.0)  # rad/s, negative is backspin
SIDESPIN = (-200.0, 0.0, 200.0)  # rad/s about the vertical
GRID = (*(MUZZLE_ACROSS, MUZZLE_ALONG, MUZZLE_HEIGHT), YAW, PITCH, SPEED, TOPSPIN, SIDESPIN)

# Standard deviations of a launch from the setting.
ANGLE_SPREAD = 0.3  # degrees
SPEED_SPREAD = 0.02  # share
SPIN_SPREAD = 0.03  # share

MISS_SHARE = 0.01  # share of the settings that do not land and are kept
SETTINGS_PER_DRAW = 4000  # settings drawn at once
MIN_LANDING_SHARE = 0.005  # smallest share of landing settings
LANDING_TIME = np.arange(0.0, 1.2, 0.02)  # s; every shot of the grid lands within it
MAX_CONTACTS = 2  # simulated per shot
VISIBLE_AFTER = 0.15  # s that a shot is recorded after its last contact


def cannon_balls(truth: Truth, shots: int, random: np.random.Generator) -> list[TrackedBall]:
    """Return the balls of a session, each on its own clock, which starts just before the launch."""
    launches = cannon_launches(truth.simulator, shots, random)
    flown = follow_contacts(truth, launches, MAX_CONTACTS, random)
    starts = random.uniform(0.0, 0.005, shots)
    balls = []
    for shot, start in enumerate(starts):
        last_visible = min(flown.last_visible[shot], flown.times[shot, -1] + VISIBLE_AFTER)
        met = flown.times[shot] < last_visible
        contacts = TrueContacts(
            start + np.concatenate([[0.0], flown.times[shot, met]]),
            np.array(["launch", *(KINDS[surface] for surface in flown.surfaces[shot, met])]),
            np.concatenate([launches[None, shot], flown.states[shot, met]]),
        )
        balls.append(TrackedBall(contacts, start + last_visible))
    return balls


def cannon_launches(simulator: Simulator, shots: int, random: np.random.Generator) -> Floats:
    """Return (shots, 9) launch states, drawn from the grid of settings.

    Settings that do not land on the near half are dropped, except for ``MISS_SHARE`` of them.

    Raises:
        ValueError: hardly any shot of the grid lands in this simulator.
    """
    session = np.empty((0, STATE_SIZE))
    while len(session) < shots:
        settings = np.stack([random.choice(values, SETTINGS_PER_DRAW) for values in GRID], axis=1)
        noise = random.standard_normal((len(settings), 5))
        settings[:, 3:5] += ANGLE_SPREAD * noise[:, :2]
        settings[:, 5] *= 1 + SPEED_SPREAD * noise[:, 2]
        settings[:, 6:] *= 1 + SPIN_SPREAD * noise[:, 3:]
        launches = launch_states(settings)
        contacts = simulator.fly(launches, LANDING_TIME).contacts
        on_table = (contacts.count > 0) & (contacts.surface[:, 0] == TABLE)
        landed = on_table & (contacts.before[:, 0, 1] < 0)
        if landed.mean() < MIN_LANDING_SHARE:
            raise ValueError("hardly any shot of the cannon lands on the table in this simulator")
        used = landed | (random.random(SETTINGS_PER_DRAW) < MISS_SHARE)
        session = np.concatenate([session, launches[used]])
    return session[:shots]


def launch_states(settings: Floats) -> Floats:
    """Return the (B, 9) launch states of (B, 8) settings, in the order and units of ``GRID``."""
    yaw, pitch = np.radians(settings[:, 3:5]).T
    speed, topspin, sidespin = settings[:, 5:].T
    ahead = np.stack([np.sin(yaw), -np.cos(yaw), np.zeros_like(yaw)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    states = np.empty((len(settings), STATE_SIZE))
    states[:, POSITION] = settings[:, :3]
    states[:, VELOCITY] = speed[:, None] * (
        np.cos(pitch)[:, None] * ahead + np.sin(pitch)[:, None] * up
    )
    # Topspin moves the top of the ball forwards: about the horizontal axis up x ahead.
    states[:, SPIN] = topspin[:, None] * np.cross(up, ahead) + sidespin[:, None] * up
    return states
