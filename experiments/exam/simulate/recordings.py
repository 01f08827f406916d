"""Recordings of a trial, for the methods, and its sealed truth, for the scoring path only."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from experiments.exam.interface import Recording
from experiments.exam.simulate.camera_errors import LabelErrors, Stamps, rising, tail_factors
from experiments.exam.simulate.equivalent_sizes import equivalent_physics
from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import physics_of
from experiments.exam.simulate.scattered_shots import (
    BallModel,
    HalfRoom,
    ScatteredShots,
    scattered_shots,
)
from experiments.exam.simulate.trial import Trial
from rallygap.models.audit.launches import Launches, launches
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE
from rallygap.models.ball.types import Floats, Integers

JITTER = 3e-4  # s to either side of a frame's regular time; its time stamp includes it
MARGIN = 0.1  # s simulated beyond the end of a recording, for a sensor that looks ahead
# Streams of random numbers; the removable gap has number 5.
LAUNCHES, BOUNCES, SENSOR, FRAMES, NOISE = range(5)
SHARED, OTHERS, VARIATION = 6, 7, 8


@dataclass(frozen=True)
class SealedTruth:
    """What the recordings of a trial hide."""

    trial: Trial  # with its causes
    parts: tuple[ScatteredShots, ...]  # in their order; one, unless a parameter varies by shot
    durations: Floats  # (B,) s that were recorded

    @property
    def shots(self) -> ScatteredShots:
        """All shots of a trial whose causes are the same in every shot.

        Raises:
            ValueError: a parameter varies by shot.
        """
        (shots,) = self.parts
        return shots

    def states(self, times: ArrayLike) -> Floats:
        """Return the (B, T, 9) true states at (T,) or (B, T) true times."""
        moments = np.atleast_2d(np.asarray(times, dtype=np.float64))
        moments = np.broadcast_to(moments, (len(self.durations), moments.shape[1]))
        return np.concatenate(
            [part.fly(part.launches, moments[rows]).states for part, rows in self._rows()]
        )

    def measured(self, times: Floats, random: np.random.Generator) -> tuple[Floats, Floats]:
        """Return exact (B, T, 3) positions and spin labels at (B, T) times of the cameras."""
        parts = [measured(part, part.launches, times[rows], random) for part, rows in self._rows()]
        positions, labels = zip(*parts, strict=True)
        return np.concatenate(positions), np.concatenate(labels)

    @property
    def bounce_times(self) -> Floats:
        """(B, K) s of the bounces, NaN beyond the last one."""
        return np.concatenate([part.contacts.time for part in self.parts])

    def _rows(self) -> Iterator[tuple[ScatteredShots, slice]]:
        start = 0
        for part in self.parts:
            yield part, slice(start, start + len(part.launches))
            start += len(part.launches)


def simulate_trial(trial: Trial) -> tuple[tuple[Recording, ...], SealedTruth]:
    """Return the recordings of a trial, and separately its sealed truth.

    Raises:
        RuntimeError: no constants of the independent dynamics correspond to the causes.
    """
    drawn = launches(trial.base, trial.shots, trial.directions, _random(trial, LAUNCHES))
    bounces = _random(trial, BOUNCES)
    parts = tuple(
        scattered_shots(
            ball,
            simulator,
            drawn.states[rows],
            drawn.durations[rows] + MARGIN,
            trial.scatter,
            bounces,
        )
        for ball, simulator, rows in _environments(trial, drawn)
    )
    truth = SealedTruth(trial, parts, drawn.durations)
    return tuple(_recordings(truth)), truth


def _environments(trial: Trial, drawn: Launches) -> Iterator[tuple[BallModel, Simulator, slice]]:
    """Yield the dynamics of shots, the simulator with their sensor effects, and their rows."""
    variation, all_rows = trial.variation, slice(None)
    if variation is None and trial.dynamics == "independent":
        yield IndependentBall(equivalent_physics(trial, drawn)), trial.simulator, all_rows
    elif variation is None:
        yield trial.simulator, trial.simulator, all_rows
    elif variation.kind == "place":
        half_room = HalfRoom(_untuned(trial, trial.simulator), _untuned(trial, trial.base))
        yield half_room, trial.base, all_rows
    else:
        hidden, mean = variation.parameter, trial.simulator
        ends, random = (hidden.value(trial.base), hidden.value(mean)), _random(trial, VARIATION)
        for shot, value in enumerate(variation.values(*ends, trial.shots, random)):
            simulator = hidden.at(mean, value)
            yield _untuned(trial, simulator), simulator, slice(shot, shot + 1)


def _untuned(trial: Trial, simulator: Simulator) -> BallModel:
    """Return the dynamics of a cause that varies.

    Constants of the independent dynamics are the parameters' values: no single value of the
    catalogue's form fits all shots.
    """
    independent = trial.dynamics == "independent"
    return IndependentBall(physics_of(simulator)) if independent else simulator


def _recordings(truth: SealedTruth) -> Iterator[Recording]:
    """Yield every shot with the errors of the cameras."""
    trial, errors = truth.trial, truth.trial.errors
    frames, noise = _random(trial, FRAMES), _random(trial, NOISE)
    times, counts = _frames(truth.durations, trial.cameras.interval, frames)
    positions, labels = truth.measured(times, _random(trial, SENSOR))
    shared = _random(trial, SHARED)  # errors that several rows share
    if errors.distortion is not None:
        positions = positions + errors.distortion.errors(positions, shared)
    if errors.labels != LabelErrors():
        arcs = (times[:, :, None] >= truth.bounce_times[:, None]).sum(axis=2)
        labels = errors.labels.added(labels, arcs, shared)
    others = _random(trial, OTHERS)  # of heavy tails and time stamps
    for shot, count in enumerate(counts):
        states = np.zeros((count, STATE_SIZE))
        states[:, POSITION], states[:, SPIN] = positions[shot, :count], labels[shot, :count]
        seen, spins, kept = trial.cameras.measure(states, noise)
        if errors.tails is not None:
            factors = tail_factors(count, errors.tails, others)
            seen = states[:, POSITION] + factors[:, None] * (seen - states[:, POSITION])
        stamps = times[shot, :count]
        if trial.time_resolution > 0.0:
            stamps = np.round(stamps / trial.time_resolution) * trial.time_resolution
        if errors.stamps != Stamps():
            stamps = errors.stamps.stamped(stamps, others)
            kept = rising(stamps, kept)
        labelled = {
            "none": np.zeros(count, dtype=bool),
            "per_shot": np.arange(count) == 0,
            "per_row": kept,
        }[trial.spin_labels]
        yield Recording(stamps[kept], seen[kept], stamps[labelled], spins[labelled])


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


def _random(trial: Trial, stream: int) -> np.random.Generator:
    return np.random.default_rng([trial.seed, stream])
