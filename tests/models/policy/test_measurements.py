"""Measurements: the path every five milliseconds, and how noisy they are."""

import numpy as np

from rallygap.models.policy.measurements import measure
from rallygap.models.policy.settings import SensorNoise
from tests.models.policy.incoming_balls import struck

CLEAN = SensorNoise(position=0.0, spin=0.0)


def test_measurements_without_noise_are_the_path_every_five_milliseconds_until_it_is_lost():
    _, path, playable = struck()
    seen, mask = measure(path, playable[:, 1], CLEAN, np.random.default_rng(0))
    counts = np.floor(playable[:, 1] / 0.005 + 1e-6) + 1
    np.testing.assert_array_equal(mask.sum(axis=1), np.tile(counts[:, None], 6))
    true = np.concatenate([path[:, ::5, :3], path[:, ::5, 6:]], axis=2)
    np.testing.assert_array_equal(seen, np.where(mask, true, 0.0))


def test_noise_has_the_deviations_that_were_asked_for():
    _, path, _ = struck()
    noise, generator = SensorNoise(position=0.003, spin=0.05), np.random.default_rng(0)
    seen, _ = measure(path, np.full(len(path), np.inf), noise, generator)
    true = path[:, ::5]
    assert abs((seen[..., :3] - true[..., :3]).std() / 0.003 - 1) < 0.03
    share = (seen[..., 3:] - true[..., 6:]) / np.linalg.norm(true[..., 6:], axis=2, keepdims=True)
    assert abs(share.std() / 0.05 - 1) < 0.03
