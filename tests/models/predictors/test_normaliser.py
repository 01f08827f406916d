"""The normaliser: uniform motion has zero deviation, unmeasured values have no effect."""

import itertools

import numpy as np
import torch
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rallygap.models.predictors.normaliser import Normaliser, uniform_motion
from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES
from tests.models.predictors.balls import FIRST, observed

ALL = torch.ones(1, 12, 6, dtype=torch.bool)
HALF_TURN = np.array([-1, -1, 1])
WEIGHT = [3.0, 1.0, 0.5]  # of position, velocity and spin


def numbers(largest):
    return arrays(float, 3, elements=st.floats(-largest, largest))


def moving(position, velocity, spin):
    """(1, 12, 6) and (1, 60, 9): a ball in uniform motion."""
    past, future = (
        np.array([[*(position + velocity * time), *velocity, *spin] for time in times])
        for times in (HISTORY_TIMES, FUTURE_TIMES)
    )
    measured = past[:, [0, 1, 2, 6, 7, 8]]
    return torch.from_numpy(measured)[None], torch.from_numpy(future)[None]


def measured_balls(seed=0, balls=200):
    """Noisy balls, half of them towards each side; a fifth of all numbers not measured."""
    random = np.random.default_rng(seed)
    first = FIRST[random.integers(0, 3, balls)] * random.uniform(0.9, 1.1, (balls, 9))
    first[::2] *= np.tile(HALF_TURN, 3)
    history, future = observed(first, noise=0.003)
    parts = torch.from_numpy(history.states), torch.from_numpy(future)
    past, future = (part.float() for part in parts)
    past[..., 3:] += torch.from_numpy(random.normal(0, 5, past[..., 3:].shape))
    future[..., 6:] += torch.from_numpy(random.normal(0, 5, future[..., 6:].shape))
    seen, measured = (torch.from_numpy(random.random(part.shape) < 0.8) for part in parts)
    return torch.where(seen, past, 0), seen, torch.where(measured, future, 0), measured


@settings(max_examples=40)
@given(numbers(5), numbers(35), numbers(1000), st.sets(st.integers(0, 11), min_size=2))
def test_a_ball_in_uniform_motion_does_not_deviate_from_it(position, velocity, spin, where):
    assume(abs(velocity[1]) > 1e-3)
    history, future = moving(position, velocity, spin)
    seen = torch.zeros_like(ALL)
    seen[:, sorted(where)] = True
    motion, normaliser = uniform_motion(history, seen), Normaliser()
    np.testing.assert_allclose(normaliser.deviation(future, motion), 0.0, atol=1e-9)
    side = np.tile(HALF_TURN if velocity[1] > 0 else np.ones(3), 2)
    way = np.hstack([position + 6 * np.outer(HISTORY_TIMES, velocity), [spin] * 12]) * side
    np.testing.assert_allclose(normaliser.normalised(history, ALL, motion)[0], way, atol=1e-8)
    ahead = future[0][:, [0, 1, 2, 6, 7, 8]] * side
    np.testing.assert_allclose(normaliser.expected(motion)[0], ahead, atol=1e-8)


@settings(max_examples=30)
@given(arrays(bool, 12), st.integers(0, 100))
def test_velocity_is_the_theil_sen_estimate(seen, seed):
    heights = np.random.default_rng(seed).normal(size=12)
    pairs = itertools.combinations(np.flatnonzero(seen), 2)
    slopes = [(heights[j] - heights[i]) / (HISTORY_TIMES[j] - HISTORY_TIMES[i]) for i, j in pairs]
    velocity = np.median(slopes) if slopes else 0.0
    now = np.median((heights - velocity * HISTORY_TIMES)[seen]) if seen.any() else 0.0
    history = torch.from_numpy(np.tile(heights[:, None], (1, 1, 6)))
    motion = uniform_motion(history, torch.from_numpy(seen)[None, :, None].expand(ALL.shape))[0]
    np.testing.assert_allclose(motion[:, 2], now + velocity * FUTURE_TIMES, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(motion[:, 5], velocity, rtol=1e-9, atol=1e-9)


def test_fitted_windows_have_mean_zero_and_spread_one_or_the_weight_and_come_back():
    history, seen, future, measured = (part.double() for part in measured_balls())
    seen, measured = seen.bool(), measured.bool()
    normaliser = fitted(history, seen, future, measured)
    motion = uniform_motion(history, seen)
    ins, outs = normaliser.normalised(history, seen, motion), normaliser.deviation(future, motion)
    means, spreads = moments(ins, seen)
    np.testing.assert_allclose(means, 0, atol=1e-9)
    np.testing.assert_allclose(spreads, 1, atol=1e-9)
    means, spreads = moments(outs, measured)
    np.testing.assert_allclose(means, 0, atol=1e-9)
    torch.testing.assert_close(normaliser.states(outs, motion), future)
    of_quantities = np.sqrt((spreads**2).reshape(3, 3).mean(axis=1))  # a millimetre is a millimetre
    np.testing.assert_allclose(of_quantities, WEIGHT, atol=1e-9)


def fitted(history, seen, future, measured):
    normaliser = Normaliser()
    normaliser.fit(history, seen, future, measured, uniform_motion(history, seen))
    return normaliser


def moments(values, known):
    """Mean and standard deviation of every column where it is known."""
    columns = np.ma.array(values, mask=~known).reshape(-1, values.shape[2])
    return columns.mean(axis=0).data, columns.std(axis=0).data


def test_unmeasured_values_have_no_effect():
    history, seen, future, measured = measured_balls()
    nonsense = torch.where(seen, history, 1e6), seen, torch.where(measured, future, 1e6), measured
    plain, filled = fitted(history, seen, future, measured), fitted(*nonsense)
    for name, value in plain.state_dict().items():
        assert torch.equal(value, filled.state_dict()[name])
    motion = uniform_motion(history, seen)
    assert torch.equal(motion, uniform_motion(nonsense[0], seen))
    for read in (plain.normalised, plain.residual):
        assert torch.equal(read(history, seen, motion), read(nonsense[0], seen, motion))


def test_a_number_that_never_varies_or_was_never_measured_stays_finite():
    history, seen, future, measured = measured_balls()
    history[..., 5], seen[..., 4], measured[..., 6:] = 0.1, False, False
    normaliser = fitted(history, seen, future, measured)
    assert normaliser.history_spread[4:].tolist() == [1.0, 1.0]
    assert normaliser.future_spread[6:].tolist() == [1 / WEIGHT[2]] * 3
    assert normaliser.history_mean[4] == 0.0
    assert not normaliser.future_mean[6:].any()
