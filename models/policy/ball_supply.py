"""Ball supply: balls and goals generated in batches and handed out one after the other."""

import numpy as np

from rallygap.models.ball.types import Bools, Integers
from rallygap.models.policy.batch_simulation import BatchSimulation
from rallygap.models.policy.task import Task

BATCH = 256  # balls generated at once, which makes a new episode cheap


class BallSupply:
    """The balls generated from one random generator, for B environments.

    Attributes:
        numbers: (B,) of the balls that the environments have, counted from zero.
    """

    def __init__(self, task: Task, environments: int, random: np.random.Generator) -> None:
        """Generate the first batch."""
        self.numbers = np.zeros(environments, dtype=np.int64)
        self._task, self._random = task, random
        self._size = max(BATCH, environments)
        self._handed_out = 0
        self._fill()

    def start_episodes(self, simulation: BatchSimulation, which: Bools) -> None:
        """Start new episodes in the environments of ``which`` (B,)."""
        waiting = np.flatnonzero(which)
        while len(waiting):
            if self._next == self._size:
                self._fill()
            served = waiting[: self._size - self._next]
            self._hand_out(simulation, served)
            waiting = waiting[len(served) :]

    def _fill(self) -> None:
        self._incoming, self._goals = self._task.draw(self._size, self._random)
        self._next = 0

    def _hand_out(self, simulation: BatchSimulation, envs: Integers) -> None:
        rows = slice(self._next, self._next + len(envs))
        which = np.zeros(len(self.numbers), dtype=np.bool_)
        which[envs] = True
        simulation.reset(which, self._incoming[rows], self._goals[rows])
        self.numbers[envs] = self._handed_out + np.arange(len(envs))
        self._handed_out += len(envs)
        self._next += len(envs)
