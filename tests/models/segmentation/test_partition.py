"""The partition into arcs and outliers."""

import numpy as np
import pytest

from rallygap.models.segmentation.partition import FEWEST_SAMPLES, partition

NOISE, CONTACT_COST, OUTLIER_COST = 0.003, 16.0, 16.0
STEP = 0.005


def arcs(t, x):
    first, _, last = partition(t, x, NOISE, CONTACT_COST, OUTLIER_COST)
    return list(zip(first.tolist(), last.tolist(), strict=True))


def path(samples, velocity, begin=(0.0, 0.0, 0.3)):
    t = STEP * np.arange(samples)[:, None]
    return np.array(begin) + t * velocity + 0.5 * t**2 * [0, 0, -9.81]


def noisy(x, seed):
    return x + np.random.default_rng(seed).normal(0, NOISE, x.shape)


def clock(x):
    return STEP * np.arange(len(x))


@pytest.mark.parametrize("seed", range(10))
def test_noise_and_outliers_do_not_break_an_arc(seed):
    x = noisy(path(80, [0.5, 4.0, 2.0]), seed)
    assert arcs(clock(x), x) == [(0, 79)]
    random = np.random.default_rng(100 + seed)
    off = random.choice(np.arange(1, 79), 8, replace=False)
    x[off] += random.choice([-1, 1], (8, 3)) * random.uniform(0.05, 0.5, (8, 3))
    assert arcs(clock(x), x) == [(0, 79)]


@pytest.mark.parametrize("between", [FEWEST_SAMPLES, 4, 5])
def test_few_samples_between_two_contacts_are_an_arc(between):
    down = path(20, [0.0, -5.0, -2.0])
    up = path(between + 1, [0.0, -4.5, 3.0], down[-1])[1:]
    back = path(20, [1.0, 8.0, 2.0], up[-1])[1:]
    x = noisy(np.concatenate([down, up, back]), 1)
    breaks = [first for first, _ in arcs(clock(x), x)[1:]]
    np.testing.assert_allclose(breaks, [20, 20 + between], atol=1)
    assert len(breaks) == 2


def test_random_samples_are_in_no_arc():
    x = np.random.default_rng(3).uniform(-2, 2, (30, 3))
    assert arcs(clock(x), x) == []
