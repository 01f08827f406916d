"""Recordings of a trial, for the candidate, and its sealed truth, for the scoring path alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from models.ball.sensor import measured
from models.ball.state import POSITION, SPIN, STATE_SIZE
from models.exam.design.trial import Recording, Trial
from models.exam.simulate.equivalent_sizes import equivalent_physics
from models.exam.simulate.independent_ball import IndependentBall
from models.exam.simulate.launches import Launches, launches
from models.exam.simulate.session import Ball, Session, played

Floats = NDArray[np.float64]

JITTER = 3e-4  # s to either side by which frames come early or late; their stamps know it
MARGIN = 0.1  # s that balls are played beyond what is seen, for a sensor that looks ahead
LAUNCHES, BOUNCES, SENSOR, FRAMES, NOISE = range(5)  # each with random numbers of its own


@dataclass(frozen=True)
class SealedTruth:
    """What is hidden in a trial's recordings.

    Attributes:
        trial: its causes among it.
        session: the balls as they were played.
        durations: (B,) s for which each was seen.
    """

    trial: Trial
    session: Session
    durations: Floats

    def states(self, times: ArrayLike) -> Floats:
        """Return the (B, T, 9) true states at (T,) or (B, T) true times."""
        return self.session.fly(self.session.launches, times).states


def held(trial: Trial) -> tuple[tuple[Recording, ...], SealedTruth]:
    """Hold a trial: return its recordings, and apart from them its sealed truth."""
    drawn = launches(trial.nominal, trial.shots, trial.directions, _random(trial, LAUNCHES))
    followed = drawn.durations + MARGIN
    session = played(
        world_of(trial, drawn),
        trial.simulator,
        drawn.states,
        followed,
        trial.scatter,
        _random(trial, BOUNCES),
    )
    truth = SealedTruth(trial, session, drawn.durations)
    return tuple(_recorded(truth)), truth


def world_of(trial: Trial, drawn: Launches) -> Ball:
    """Return what flies a trial's balls: the simulator with the causes, or the independent ball."""
    if trial.world == "independent":
        return IndependentBall(equivalent_physics(trial, drawn))
    return trial.simulator


def _recorded(truth: SealedTruth) -> list[Recording]:
    trial, session = truth.trial, truth.session
    frames, noise = _random(trial, FRAMES), _random(trial, NOISE)
    times, counts = _frames(truth.durations, trial.cameras.interval, frames)
    positions, labels = measured(session, session.launches, times, _random(trial, SENSOR))
    recordings = []
    for shot, count in enumerate(counts):
        rows = slice(0, count)
        seen = _Seen(times[shot, rows], positions[shot, rows], labels[shot, rows])
        recordings.append(seen.recorded(trial, noise))
    return recordings


def _frames(
    durations: Floats, interval: float, random: np.random.Generator
) -> tuple[Floats, NDArray[np.int64]]:
    """Return (B, T) frame times, the last one repeated at the end, and how many a shot has."""
    phase = random.uniform(JITTER, interval, len(durations))
    counts = np.maximum(((durations - phase) / interval).astype(np.int64) + 1, 1)
    number = np.arange(counts.max())
    jitter = random.uniform(-JITTER, JITTER, (len(durations), len(number)))
    times = phase[:, None] + interval * number + jitter
    last = np.minimum(number, counts[:, None] - 1)
    return np.take_along_axis(times, last, axis=1), counts


@dataclass(frozen=True)
class _Seen:
    """One shot as the sensor shows it, before noise."""

    times: Floats
    positions: Floats
    labels: Floats

    def recorded(self, trial: Trial, random: np.random.Generator) -> Recording:
        states = np.zeros((len(self.times), STATE_SIZE))
        states[:, POSITION], states[:, SPIN] = self.positions, self.labels
        positions, labels, seen = trial.cameras.measure(states, random)
        times = self.times
        if trial.stamp > 0.0:
            times = np.round(times / trial.stamp) * trial.stamp
        labelled = {
            "none": np.zeros(len(seen), dtype=bool),
            "per_shot": np.arange(len(seen)) == 0,
            "per_row": seen,
        }[trial.spin_labels]
        return Recording(times[seen], positions[seen], times[labelled], labels[labelled])


def _random(trial: Trial, stream: int) -> np.random.Generator:
    return np.random.default_rng([trial.seed, stream])
