"""A session: recordings of games and of the cannon, streamed in a fixed order.

Everything is simulated in batches of a fixed size, each with a generator of its own, so that
a longer session begins with the recordings of a shorter one, wherever batches are simulated.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil

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
ROUND = 100  # batches that are shared out at once: so many may wait in memory for their turn

Batch = list[ArenaRecording]
Share = Callable[[Sequence[Callable[[], Batch]]], Iterable[Batch]]


def one_by_one(tasks: Sequence[Callable[[], Batch]]) -> Iterator[Batch]:
    """Simulate batches here, each when it is asked for."""
    return (task() for task in tasks)


def recordings(
    settings: ArenaSettings, truth: Truth, seed: int, share: Share = one_by_one
) -> Iterator[ArenaRecording]:
    """Stream a session: the cannon's shots, then games of all levels in turn.

    Args:
        settings: how much, and how well it is seen.
        truth: the hall's physics.
        seed: of the session; the same seed gives the same recordings.
        share: does the tasks of a round, and gives what they return in their order.
    """
    hall = Hall(truth, _cameras(settings, truth), seed)
    yield from _cannon(hall, settings.cannon_shots, share)
    yield from _games(hall, settings.game_episodes, share)


@dataclass(frozen=True)
class Hall:
    """Where batches of a session are simulated, each on its own."""

    truth: Truth
    cameras: Cameras
    seed: int

    def cannon(self, shots: range) -> Batch:
        """Simulate a batch of the cannon's shots; the last one may want fewer than it has."""
        random = self._random(CANNON_STREAM, shots.start // CANNON_BATCH)
        balls = cannon_balls(self.truth, CANNON_BATCH, random)
        seen = observe(self.truth, self.cameras, balls, random)
        return [
            ArenaRecording(f"cannon/{shot:05d}", one.times, one.positions, one.spins, ball.contacts)
            for shot, ball, one in zip(shots, balls, seen, strict=False)
        ]

    def games(self, level: str, batch: int) -> Batch:
        """Simulate a batch of matches between players of a level."""
        random = self._random(GAME_STREAMS + list(LEVELS).index(level), batch)
        matches = range(batch * MATCH_BATCH, (batch + 1) * MATCH_BATCH)
        return list(games(self.truth, self.cameras, level, matches, random))

    def _random(self, stream: int, batch: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, stream, batch])


def _cannon(hall: Hall, shots: int, share: Share) -> Iterator[ArenaRecording]:
    firsts = range(0, shots, CANNON_BATCH)
    tasks = [partial(hall.cannon, range(shots)[one : one + CANNON_BATCH]) for one in firsts]
    for done in range(0, len(tasks), ROUND):
        for batch in share(tasks[done : done + ROUND]):
            yield from batch


def _games(hall: Hall, episodes: int, share: Share) -> Iterator[ArenaRecording]:
    strokes = played = 0
    while strokes < episodes:
        # Only playing tells how many strokes a batch of every level has.
        missing = ceil((episodes - strokes) * played / strokes) if played else 1
        numbers = range(played, played + min(missing, ROUND // len(LEVELS)))
        for turn in _turns(hall, numbers, share):
            if strokes < episodes:
                strokes += sum(point.strokes for game in turn for point in game.points)
                yield from turn
        played = numbers.stop


def _turns(hall: Hall, numbers: range, share: Share) -> Iterator[tuple[ArenaRecording, ...]]:
    """Yield a recording of every level at a time, from batches with these numbers."""
    batches = iter(share([partial(hall.games, one, n) for n in numbers for one in LEVELS]))
    for of_levels in zip(*[batches] * len(LEVELS), strict=True):
        yield from zip(*of_levels, strict=True)


def _cameras(settings: ArenaSettings, truth: Truth) -> Cameras:
    return Cameras(
        position_noise=settings.position_noise,
        spin_noise=settings.spin_noise,
        dropouts=settings.dropouts,
        outliers=settings.outliers,
        slow_error=truth.slow_error,
        interval=1 / settings.rate_hz,
    )
