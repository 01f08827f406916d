"""Simulated replicates of shots: the same launches and times, with new kicks and noise."""

from dataclasses import replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.measurement import Prediction, Schedule, predict_measurements
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.fit.trajectory import KICK_SIZE


def simulate_replicate(
    shots: Shots,
    simulator: Simulator,
    states: Floats,
    noise: Noise,
    max_kicks: int,
    random: np.random.Generator,
) -> Shots:
    """Return a simulated replicate of measured shots.

    Args:
        shots: B of them, whose times and labels' times are kept.
        simulator: with its sensor effects.
        states: (B, 9) at the first sample.
        noise: of the sensor, and scatter of bounces.
        max_kicks: bounces of a shot that scatter.
        random: draws both.
    """
    kicks = random.standard_normal((len(shots), max_kicks, KICK_SIZE)) * noise.scatter
    nuisance = np.hstack([states, kicks.reshape(len(shots), -1)])
    prediction = predict_measurements(simulator, Schedule.of(shots), nuisance)
    positions = prediction.positions + _position_errors(shots, prediction, noise, random)
    return replace(shots, positions=positions, labels=_labels(shots, prediction, noise, random))


def _position_errors(
    shots: Shots, prediction: Prediction, noise: Noise, random: np.random.Generator
) -> Floats:
    """Return (B, N, 3) m: white noise, slow errors, and those of the time stamps."""
    white = noise.white * random.standard_normal(prediction.positions.shape)
    stamps = noise.timing * random.standard_normal(shots.times.shape)
    slow = noise.slow * random.standard_normal(prediction.positions.shape)
    kept = np.exp(-np.diff(shots.times, axis=1) / noise.slow_time)[..., None]
    for i in range(kept.shape[1]):
        slow[:, i + 1] = kept[:, i] * slow[:, i] + np.sqrt(1 - kept[:, i] ** 2) * slow[:, i + 1]
    return white + slow + stamps[..., None] * prediction.velocities


def _labels(
    shots: Shots, prediction: Prediction, noise: Noise, random: np.random.Generator
) -> Floats:
    """Return (B, L, 3) labels with errors of every row, of every arc and of the shot."""
    errors = noise.label * random.standard_normal(prediction.labels.shape)
    arcs = prediction.arcs(shots.label_times - shots.times[:, :1])
    of_arcs = random.standard_normal((len(shots), int(arcs.max(initial=0)) + 1, 3))
    errors += noise.label_arc * np.take_along_axis(of_arcs, arcs[..., None], axis=1)
    errors += noise.label_common * random.standard_normal((len(shots), 1, 3))
    sizes = np.linalg.norm(prediction.labels, axis=-1, keepdims=True)
    return np.where(shots.labelled[..., None], prediction.labels + sizes * errors, np.nan)
