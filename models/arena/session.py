"""Sessions of the arena: recordings of the cannon and of games, streamed in a fixed order.

Everything is simulated in batches of a fixed size, each with its own random generator. The result
therefore does not depend on where batches run, and a longer session starts with the recordings of
a shorter one.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil

import numpy as np

from rallygap.models.arena.cameras import Cameras
from rallygap.models.arena.cannon import cannon_balls
from rallygap.models.arena.games import games
from rallygap.models.arena.levels import LEVELS
from rallygap.models.arena.recording import ArenaRecording
from rallygap.models.arena.settings import ArenaSettings
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import observe

CANNON_STREAM = 0
CANNON_BATCH = 250  # shots
GAME_STREAMS = 1  # one stream per level from here on
MATCH_BATCH = 25  # matches
ROUND = 100  # batches submitted at once; so many may wait in memory

Batch = list[ArenaRecording]
# Runs tasks and yields their results in order.
RunTasks = Callable[[Sequence[Callable[[], Batch]]], Iterable[Batch]]


def run_sequentially(tasks: Sequence[Callable[[], Batch]]) -> Iterator[Batch]:
    """Run tasks in this process, each when its result is requested."""
    return (task() for task in tasks)


def recordings(
    settings: ArenaSettings, truth: Truth, seed: int, run_tasks: RunTasks = run_sequentially
) -> Iterator[ArenaRecording]:
    """Stream a session: shots of the cannon, then games, one level after the other."""
    cameras = Cameras(
        position_noise=settings.position_noise,
        spin_noise=settings.spin_noise,
        dropouts=settings.dropouts,
        outliers=settings.outliers,
        slow_error=truth.slow_error,
        interval=1 / settings.rate_hz,
        field=truth.camera_field,
        arc_spin_noise=truth.arc_spin_noise,
    )
    simulator = BatchSimulator(truth, cameras, seed)
    shots = range(settings.cannon_shots)
    tasks = [partial(simulator.cannon, shots[k : k + CANNON_BATCH]) for k in shots[::CANNON_BATCH]]
    for done in range(0, len(tasks), ROUND):
        for batch in run_tasks(tasks[done : done + ROUND]):
            yield from batch
    yield from _games(simulator, settings.game_episodes, run_tasks)


@dataclass(frozen=True)
class BatchSimulator:
    """Simulates batches of a session independently of each other."""

    truth: Truth
    cameras: Cameras
    seed: int

    def cannon(self, shots: range) -> Batch:
        """Simulate a batch of the cannon's shots; the last batch may be cut."""
        random = self._random(CANNON_STREAM, shots.start // CANNON_BATCH)
        balls = cannon_balls(self.truth, CANNON_BATCH, random)
        samples = observe(self.truth, self.cameras, balls, random)
        return [
            ArenaRecording(f"cannon/{shot:05d}", *measured, ball.contacts)
            for shot, ball, measured in zip(shots, balls, samples, strict=False)
        ]

    def games(self, level: str, batch: int) -> Batch:
        """Simulate a batch of matches between players of a level."""
        random = self._random(GAME_STREAMS + LEVELS.index(level), batch)
        matches = range(batch * MATCH_BATCH, (batch + 1) * MATCH_BATCH)
        return list(games(self.truth, self.cameras, level, matches, random))

    def _random(self, stream: int, batch: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, stream, batch])


def _games(
    simulator: BatchSimulator, episodes: int, run_tasks: RunTasks
) -> Iterator[ArenaRecording]:
    """Yield games in turns of one recording of every level, until they have enough strokes."""
    strokes = played = 0
    while strokes < episodes:
        # The number of strokes of a batch is known only after it is simulated.
        missing = ceil((episodes - strokes) * played / strokes) if played else 1
        numbers = range(played, played + min(missing, ROUND // len(LEVELS)))
        tasks = [partial(simulator.games, level, n) for n in numbers for level in LEVELS]
        batches = iter(run_tasks(tasks))
        for of_levels in zip(*[batches] * len(LEVELS), strict=True):
            for turn in zip(*of_levels, strict=True):
                if strokes < episodes:
                    strokes += sum(point.strokes for game in turn for point in game.points)
                    yield from turn
        played = numbers.stop
