"""Rehearsals err as the noise says, about what a simulator's sensor sees."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.measurement import Schedule, predict_measurements
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.verify.replicates import simulate_replicate
from tests.models.gap.hidden import NOMINAL, SETTINGS, launches, measured

NOISE = Noise(white=0.003, slow=0.004, slow_time=0.02, label=0.1, label_common=0.05, timing=0.0)
EVEN = replace(NOISE, scatter=(0.0, 0.0, 0.0))
STATES = launches(200, np.random.default_rng(0))  # those of the shots measured


def errors(noise, count=200):
    """Rehearsed shots, their errors in position, and those of labels as shares of the spin."""
    shots = measured(count=count)
    again = simulate_replicate(
        shots, NOMINAL, STATES[:count], noise, SETTINGS.fit.max_kicks, np.random.default_rng(1)
    )
    prediction = predict_measurements(NOMINAL, Schedule.of(shots), STATES[:count])
    sizes = np.linalg.norm(prediction.labels, axis=2, keepdims=True)
    return again, again.positions - prediction.positions, (again.labels - prediction.labels) / sizes


def test_replicates_without_noise_are_simulated_shots():
    still = dict.fromkeys(("white", "slow", "label", "label_arc", "label_common", "timing"), 0.0)
    again, off, turned = errors(replace(EVEN, **still), count=5)
    assert np.abs(off).max() < 1e-12
    assert np.abs(turned[again.labelled]).max() < 1e-12
    assert np.isnan(again.labels[~again.labelled]).all()


def test_positions_have_white_and_slow_errors():
    again, off, _ = errors(EVEN)
    long = off[again.valid.all(axis=1) | (again.valid.sum(axis=1) > 40), :40]
    assert long.std() == pytest.approx(NOISE.position, rel=0.03)
    kept = np.mean(long[:, 1:] * long[:, :-1]) / NOISE.slow**2
    assert kept == pytest.approx(np.exp(-0.005 / NOISE.slow_time), abs=0.05)


def test_errors_of_time_stamps_are_along_the_velocity():
    _, off, _ = errors(replace(EVEN, white=1e-9, slow=0.0, timing=0.001))
    first, velocities = off[:, 0], STATES[:, 3:6]
    lengths = np.einsum("bi,bi->b", first, velocities) / (velocities**2).sum(axis=1)
    assert lengths.std() == pytest.approx(0.001, rel=0.15)
    across = first - lengths[:, None] * velocities
    assert np.abs(across).max() < 1e-6


def test_labels_have_independent_and_common_errors_and_those_of_their_arc():
    again, _, turned = errors(EVEN)
    rows = zip(turned, again.labelled, strict=True)
    means = np.stack([row[there].mean(axis=0) for row, there in rows])
    assert means.std() == pytest.approx(NOISE.label_common, rel=0.2)
    apart = (turned - means[:, None])[again.labelled]
    assert apart.std() == pytest.approx(NOISE.label, rel=0.05)

    shots, _, turned = errors(replace(EVEN, label=1e-9, label_common=1e-9, label_arc=0.05))
    since = shots.label_times - shots.times[:, :1]
    arcs = predict_measurements(NOMINAL, Schedule.of(shots), STATES).arcs(since)
    for arc in range(2):
        inside = (arcs == arc) & shots.labelled
        count = inside.sum(axis=1)
        means = np.where(inside[..., None], turned, 0.0).sum(axis=1)[count > 0]
        means = means / count[count > 0, None]
        assert means.std() == pytest.approx(0.05, rel=0.2)
        apart = np.abs(turned[count > 0] - means[:, None])
        assert apart[inside[count > 0]].max() < 1e-6


def test_bounces_scatter():
    _, even, _ = errors(replace(EVEN, white=1e-9, slow=0.0))
    _, odd, _ = errors(replace(NOISE, white=1e-9, slow=0.0, scatter=(0.05, 0.0, 0.0)))
    assert np.abs(even).max() < 1e-6
    assert odd[:, :5] == pytest.approx(even[:, :5], abs=1e-6)  # none has bounced yet
    assert np.abs(odd[..., 2]).max() > 0.02
