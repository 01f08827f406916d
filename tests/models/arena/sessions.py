"""Shared by the tests of the arena: truth, settings and a small session."""

from dataclasses import replace
from functools import cache

import numpy as np

from rallygap.models.arena.cameras import CameraField
from rallygap.models.arena.session import recordings
from rallygap.models.arena.settings import ArenaSettings
from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.state import BALL_RADIUS

HIDDEN = draw_truth(0)
NO_FIELD = CameraField(standard_deviation=0.0, length=1.0, seed=0)
TRUTH = replace(HIDDEN, camera_field=NO_FIELD, arc_spin_noise=0.0)
LEVELS = ("amateur", "club", "semi_pro", "pro")


def settings(game_episodes=0, cannon_shots=0, **changes):
    perfect = {"position_noise": 0.0, "spin_noise": 0.0, "dropouts": 0.0, "outliers": 0.0}
    return ArenaSettings(
        physics=None,
        game_episodes=game_episodes,
        cannon_shots=cannon_shots,
        **{"rate_hz": 200.0, **perfect, **changes},
    )


@cache
def session(seed=0):
    """Some 1,500 strokes and 40 shots, seen by perfect cameras."""
    return list(recordings(settings(game_episodes=1500, cannon_shots=40), TRUTH, seed))


def of_group(group):
    return [recording for recording in session() if recording.name.startswith(f"{group}/")]


def games():
    return [recording for recording in session() if recording.points]


def flying(count, random, fastest=35.0, most_spin=1000.0):
    """Return states just over the table that fly at it, up to the extremes of the game."""
    states = np.zeros((count, 9))
    states[:, :2] = random.uniform(-0.7, 0.7, (count, 2))
    states[:, 1] += np.where(states[:, 1] > 0, 0.3, -0.3)  # clear of the net
    states[:, 2] = BALL_RADIUS + 0.05
    states[:, 3:6] = _directions(count, random) * random.uniform(1.0, fastest, (count, 1))
    states[:, 5] = -np.abs(states[:, 5]) - 0.5
    states[:, 6:] = _directions(count, random) * random.uniform(0.0, most_spin, (count, 1))
    return states


def _directions(count, random):
    directions = random.standard_normal((count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)
