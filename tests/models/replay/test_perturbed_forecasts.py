"""Forecasts that are wrong on purpose are wrong by what was asked for, and in nothing else."""

import numpy as np
import pytest

from rallygap.models.replay.perturbed_forecasts import ERRORS

FORECASTS = np.random.default_rng(0).normal(size=(400, 20, 3, 9))


def degraded(error, size=0.05, seed=1):
    return ERRORS[error](FORECASTS, size, np.random.default_rng(seed)) - FORECASTS


def test_a_bias_is_the_same_at_all_ticks_and_its_directions_are_even():
    off = degraded("bias")[..., :3]
    np.testing.assert_allclose(np.linalg.norm(off, axis=-1), 0.05)
    np.testing.assert_allclose(off, np.broadcast_to(off[:, :1, :1], off.shape), atol=1e-12)
    assert np.abs(off[:, 0, 0].mean(axis=0)).max() < 0.006


def test_noise_is_drawn_at_every_tick_and_shared_by_its_horizons():
    off = degraded("noise")[..., :3]
    assert np.sqrt((off**2).sum(axis=-1).mean()) == pytest.approx(0.05, rel=0.02)
    np.testing.assert_allclose(off, np.broadcast_to(off[:, :, :1], off.shape), atol=1e-12)
    neighbours = np.corrcoef(off[:, :-1, 0].ravel(), off[:, 1:, 0].ravel())[0, 1]
    assert abs(neighbours) < 0.02


@pytest.mark.parametrize("error", ["bias", "noise"])
def test_velocities_and_spins_are_unchanged(error):
    assert not degraded(error)[..., 3:].any()


@pytest.mark.parametrize("error", ["bias", "noise"])
def test_errors_of_all_sizes_have_the_same_directions(error):
    np.testing.assert_allclose(degraded(error, 0.1), 2 * degraded(error, 0.05), atol=1e-12)


def test_without_spin_everything_else_is_unchanged():
    told = degraded("no_spin") + FORECASTS
    assert not told[..., 6:].any()
    np.testing.assert_allclose(told[..., :6], FORECASTS[..., :6])
