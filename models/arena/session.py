"""A session: recordings of games and of the cannon, streamed in a fixed order.

Everything is simulated in batches of a fixed size, each with a generator of its own, so that
a longer session begins with the recordings of a shorter one.
"""

from collections.abc import Iterator
from itertools import count, islice

import numpy as np

from models.arena.cameras import Cameras
from models.arena.cannon import cannon_balls
from models.arena.games import games
from models.arena.levels import LEVELS
from models.arena.observation import observe
from models.arena.recording import ArenaRecording
from models.arena.settings import ArenaSettings
from models.arena.truth import Truth

CANNON_STREAM = 0
CANNON_BATCH = 250  # shots
GAME_STREAMS = 1  # and one more for each further level
MATCH_BATCH = 25  # matches


def recordings(settings: ArenaSettings, truth: Truth, seed: int) -> Iterator[ArenaRecording]:
    """Stream a session: the cannon's shots, then games of all levels in turn.

    Args:
        settings: how much, and how well it is seen.
        truth: the hall's physics.
        seed: of the session; the same seed gives the same recordings.
    """
    cameras = _cameras(settings, truth)
    yield from islice(_cannon(cameras, truth, seed), settings.cannon_shots)
    streams = [_games(cameras, truth, level, seed) for level in LEVELS]
    strokes = 0
    while strokes < settings.game_episodes:
        for stream in streams:
            recording = next(stream)
            strokes += sum(point.strokes for point in recording.points)
            yield recording


def _cannon(cameras: Cameras, truth: Truth, seed: int) -> Iterator[ArenaRecording]:
    numbers = count()
    for batch in count():
        random = np.random.default_rng([seed, CANNON_STREAM, batch])
        balls = cannon_balls(truth, CANNON_BATCH, random)
        for ball, seen in zip(balls, observe(truth, cameras, balls, random), strict=True):
            name = f"cannon/{next(numbers):05d}"
            yield ArenaRecording(name, seen.times, seen.positions, seen.spins, ball.contacts)


def _games(cameras: Cameras, truth: Truth, level: str, seed: int) -> Iterator[ArenaRecording]:
    stream = GAME_STREAMS + list(LEVELS).index(level)
    for batch in count():
        random = np.random.default_rng([seed, stream, batch])
        matches = range(batch * MATCH_BATCH, (batch + 1) * MATCH_BATCH)
        yield from games(truth, cameras, level, matches, random)


def _cameras(settings: ArenaSettings, truth: Truth) -> Cameras:
    return Cameras(
        position_noise=settings.position_noise,
        spin_noise=settings.spin_noise,
        dropouts=settings.dropouts,
        outliers=settings.outliers,
        slow_error=truth.slow_error,
        interval=1 / settings.rate_hz,
    )
