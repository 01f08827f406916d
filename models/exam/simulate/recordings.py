"""Recordings of a trial, for the methods, and its sealed truth, for the scoring path only."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from models.ball.sensor import measured
from models.ball.state import POSITION, SPIN, STATE_SIZE
from models.ball.types import Floats, Integers
from models.exam.interface import Recording
from models.exam.simulate.equivalent_sizes import equivalent_physics
from models.exam.simulate.independent_ball import IndependentBall
from models.exam.simulate.launches import Launches, launches
from models.exam.simulate.scattered_shots import BallModel, ScatteredShots, scattered_shots
from models.exam.simulate.trial import Trial

JITTER = 3e-4  # s to either side of a frame's regular time; its time stamp includes it
MARGIN = 0.1  # s simulated beyond the end of a recording, for a sensor that looks ahead
LAUNCHES, BOUNCES, SENSOR, FRAMES, NOISE = range(5)  # streams of random numbers


@dataclass(frozen=True)
class SealedTruth:
    """What the recordings of a trial hide."""

    trial: Trial  # with its causes
    shots: ScatteredShots  # as simulated
    durations: Floats  # (B,) s that were recorded

    def states(self, times: ArrayLike) -> Floats:
        """Return the (B, T, 9) true states at (T,) or (B, T) true times."""
        return self.shots.fly(self.shots.launches, times).states


def simulate_trial(trial: Trial) -> tuple[tuple[Recording, ...], SealedTruth]:
    """Return the recordings of a trial, and separately its sealed truth."""
    drawn = launches(trial.nominal, trial.shots, trial.directions, _random(trial, LAUNCHES))
    shots = scattered_shots(
        ball_model(trial, drawn),
        trial.simulator,
        drawn.states,
        drawn.durations + MARGIN,
        trial.scatter,
        _random(trial, BOUNCES),
    )
    truth = SealedTruth(trial, shots, drawn.durations)
    return tuple(_recordings(truth)), truth


def ball_model(trial: Trial, drawn: Launches) -> BallModel:
    """Return the dynamics of a trial: the simulator with the causes, or the independent ball."""
    if trial.dynamics == "independent":
        return IndependentBall(equivalent_physics(trial, drawn))
    return trial.simulator


def _recordings(truth: SealedTruth) -> list[Recording]:
    trial, shots = truth.trial, truth.shots
    frames, noise = _random(trial, FRAMES), _random(trial, NOISE)
    times, counts = _frames(truth.durations, trial.cameras.interval, frames)
    positions, labels = measured(shots, shots.launches, times, _random(trial, SENSOR))
    return [
        _recording(trial, times[shot, :count], positions[shot, :count], labels[shot, :count], noise)
        for shot, count in enumerate(counts)
    ]


def _frames(
    durations: Floats, interval: float, random: np.random.Generator
) -> tuple[Floats, Integers]:
    """Return (B, T) frame times, the last one repeated at the end, and how many a shot has."""
    phase = random.uniform(JITTER, interval, len(durations))
    counts = np.maximum(((durations - phase) / interval).astype(np.int64) + 1, 1)
    number = np.arange(counts.max())
    jitter = random.uniform(-JITTER, JITTER, (len(durations), len(number)))
    times = phase[:, None] + interval * number + jitter
    last = np.minimum(number, counts[:, None] - 1)
    return np.take_along_axis(times, last, axis=1), counts


def _recording(
    trial: Trial, times: Floats, positions: Floats, labels: Floats, random: np.random.Generator
) -> Recording:
    """Return one shot with the errors of the cameras, from exact measurements."""
    states = np.zeros((len(times), STATE_SIZE))
    states[:, POSITION], states[:, SPIN] = positions, labels
    positions, labels, kept = trial.cameras.measure(states, random)
    if trial.time_resolution > 0.0:
        times = np.round(times / trial.time_resolution) * trial.time_resolution
    labelled = {
        "none": np.zeros(len(kept), dtype=bool),
        "per_shot": np.arange(len(kept)) == 0,
        "per_row": kept,
    }[trial.spin_labels]
    return Recording(times[kept], positions[kept], times[labelled], labels[labelled])


def _random(trial: Trial, stream: int) -> np.random.Generator:
    return np.random.default_rng([trial.seed, stream])
