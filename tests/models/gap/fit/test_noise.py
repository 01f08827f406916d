"""Noise: whitening and Gram matrices against dense covariance matrices."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag

from rallygap.models.gap.fit.linearize import ballistic_nuisance, linearise
from rallygap.models.gap.fit.noise import ANY_SPIN, Noise, gram_matrices, white_gram
from rallygap.models.gap.hypotheses import Hypothesis
from tests.models.gap.hidden import NOMINAL, launches, measured

NOISE = Noise(
    white=0.003,
    slow=0.002,
    slow_time=0.04,
    label=0.05,
    label_arc=0.04,
    label_common=0.03,
    scatter=(0.01, 0.02, 0.03),
    timing=0.0,
)
COLUMNS = (Hypothesis("drag", "cd"), Hypothesis("spin_gain", "s"))
SHOTS = measured(count=3, seconds=0.3)
UNKNOWNS = ballistic_nuisance(launches(3, np.random.default_rng(0)), 1)
LINEAR = linearise(SHOTS, NOMINAL, UNKNOWNS, COLUMNS)
WEIGHTS = np.where(np.arange(SHOTS.times.shape[1]) % 7 == 3, 0.2, 1.0) * SHOTS.valid


@pytest.mark.parametrize("timing", [0.0, 4e-4])
def test_whitened_rows_have_the_products_of_the_dense_covariance(timing):
    """Errors of time stamps are along the velocity."""
    noise = replace(NOISE, timing=timing)
    products, determinants = white_gram(LINEAR.positions, LINEAR, noise, WEIGHTS)
    for shot in range(3):
        used = LINEAR.sampled[shot]
        velocities = LINEAR.velocities[shot, used]
        speeds = np.linalg.norm(velocities, axis=1)
        gains = np.hypot(1.0, timing * speeds / noise.white)
        turns = velocities[..., None] * velocities[:, None] / speeds[:, None, None] ** 2
        stretch = block_diag(*(np.eye(3) + (gains - 1)[:, None, None] * turns))
        t = SHOTS.times[shot, used]
        slow = noise.slow**2 * np.exp(-np.abs(t[:, None] - t) / noise.slow_time)
        white = np.diag(noise.white**2 / WEIGHTS[shot, used])
        dense = stretch @ np.kron(slow + white, np.eye(3)) @ stretch
        columns = LINEAR.positions[shot, used].reshape(3 * len(t), -1)
        expected = columns.T @ np.linalg.solve(dense, columns)
        assert products[shot] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        assert determinants[shot] == pytest.approx(np.linalg.slogdet(dense)[1])


@pytest.mark.parametrize("labels", ["rows", "one"])
def test_labels_have_the_products_of_their_dense_covariance(labels):
    shots = measured(count=3, labels=labels)
    linear = linearise(shots, NOMINAL, UNKNOWNS, COLUMNS)
    parts = gram_matrices(linear, NOISE, shots.valid * 1.0, np.ones(3))
    assert labels == "one" or linear.in_arcs.any(axis=1).sum(axis=1).max() > 1
    for shot in range(3):
        used = linear.labelled[shot]
        arcs = linear.label_arcs[shot, used]
        dense = NOISE.label**2 * np.eye(used.sum()) + NOISE.label_common**2
        dense += NOISE.label_arc**2 * (arcs[:, None] == arcs)
        rows = linear.labels[shot, used]
        expected = sum(rows[:, a].T @ np.linalg.solve(dense, rows[:, a]) for a in range(3))
        found = (parts.total(NOISE) - parts.positions)[shot]
        own = np.arange(linear.nuisance_count)
        found[own, own] -= parts.precision(NOISE)[shot]
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
        assert parts.label_determinants(NOISE)[shot] == pytest.approx(
            3 * np.linalg.slogdet(dense)[1]
        )


def test_kicks_have_a_prior_and_unlabelled_spins_a_diffuse_one():
    bare = measured(count=3, seconds=0.3, labels=None)
    nuisance = UNKNOWNS.copy()
    nuisance[:, 9:] = 0.05
    linear = linearise(bare, NOMINAL, nuisance, ())
    parts = gram_matrices(linear, NOISE, WEIGHTS, np.ones(3))
    prior = (parts.total(NOISE) - parts.positions)[0]
    assert np.diag(prior)[6:9] == pytest.approx(ANY_SPIN**-2)
    assert prior[9:12, -1] == pytest.approx(-0.05 * np.array(NOISE.scatter) ** -2.0)
    assert np.all(prior[:9, -1] == 0.0)
