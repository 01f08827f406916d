"""Cameras: noise of the size that was asked for, and nothing else."""

import numpy as np
import pytest

from models.arena.cameras import OUTLIER_DISTANCE, Cameras, SlowError

SAMPLES = 40_000
SPIN = np.array([300.0, 0.0, 400.0])
STATES = np.tile([0.1, 0.2, 0.3, 0, -5, 0, *SPIN], (SAMPLES, 1))


def measure(position_noise=0.0, spin_noise=0.0, dropouts=0.0, outliers=0.0, seed=0, share=0.0):
    slow_error = SlowError(share, time=0.05)
    cameras = Cameras(position_noise, spin_noise, dropouts, outliers, slow_error, interval=0.005)
    return cameras.measure(STATES, np.random.default_rng(seed))


def test_perfect_cameras_see_the_truth():
    positions, spins, seen = measure()

    assert np.array_equal(positions, STATES[:, :3])
    assert np.array_equal(spins, STATES[:, 6:])
    assert seen.all()


def test_position_noise_has_its_size_in_every_direction():
    errors = measure(position_noise=0.003)[0] - STATES[:, :3]

    assert errors.std(axis=0) == pytest.approx([0.003] * 3, rel=0.02)
    assert np.abs(errors.mean(axis=0)).max() < 4 * 0.003 / np.sqrt(SAMPLES)


def test_the_slow_part_keeps_the_size_and_falls_off_with_its_time():
    errors = measure(position_noise=0.003, share=0.4)[0] - STATES[:, :3]

    assert errors.std(axis=0) == pytest.approx([0.003] * 3, rel=0.05)
    variance = (errors**2).mean()
    for lag, expected in ((1, 0.4 * np.exp(-0.1)), (10, 0.4 * np.exp(-1)), (100, 0.0)):
        correlation = (errors[lag:] * errors[:-lag]).mean() / variance
        assert correlation == pytest.approx(expected, abs=0.03)


def test_spin_noise_is_a_share_of_the_whole_spin():
    errors = measure(spin_noise=0.05)[1] - SPIN

    assert errors.std(axis=0) == pytest.approx([0.05 * 500] * 3, rel=0.02)


def test_outliers_are_as_frequent_and_as_far_as_stated():
    positions, _, _ = measure(outliers=0.01)

    distance = np.linalg.norm(positions - STATES[:, :3], axis=1)
    outlying = distance[distance > 0]
    assert len(outlying) / SAMPLES == pytest.approx(0.01, rel=0.2)
    assert outlying.min() >= OUTLIER_DISTANCE[0]
    assert outlying.max() <= OUTLIER_DISTANCE[1]


def test_dropouts_are_as_frequent_as_stated():
    _, _, seen = measure(dropouts=0.02)

    assert (~seen).mean() == pytest.approx(0.02, rel=0.15)
