"""Cameras: noise and a smooth field of the sizes that were asked for, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.arena.cameras import OUTLIER_DISTANCE, CameraField, Cameras, SlowError

SAMPLES = 40_000
SPIN = np.array([300.0, 0.0, 400.0])
STATES = np.tile([0.1, 0.2, 0.3, 0, -5, 0, *SPIN], (SAMPLES, 1))
FIELD = CameraField(standard_deviation=0.0015, length=0.8, seed=3)
NOISY = Cameras(0.003, 0.05, 0.2, 0.2, SlowError(0.3, 0.05), interval=0.005)
PERFECT = Cameras(0.0, 0.0, 0.0, 0.0, SlowError(0.0, 0.05), interval=0.005)


def measure(arcs=None, **errors):
    return replace(PERFECT, **errors).measure(STATES, np.random.default_rng(0), arcs)


def test_the_slow_part_keeps_the_size_and_falls_off_with_its_time():
    slow = SlowError(share=0.4, time=0.05)
    errors = measure(position_noise=0.003, slow_error=slow)[0] - STATES[:, :3]
    assert errors.std(axis=0) == pytest.approx([0.003] * 3, rel=0.05)
    white = measure(position_noise=0.003)[0] - STATES[:, :3]
    assert white.std(axis=0) == pytest.approx([0.003] * 3, rel=0.02)
    variance = (errors**2).mean()
    for lag, expected in ((1, 0.4 * np.exp(-0.1)), (10, 0.4 * np.exp(-1)), (100, 0.0)):
        correlation = (errors[lag:] * errors[:-lag]).mean() / variance
        assert correlation == pytest.approx(expected, abs=0.03)


def test_outliers_and_dropouts_are_as_frequent_and_as_far_as_stated():
    positions, _, seen = measure(outliers=0.01, dropouts=0.02)

    distance = np.linalg.norm(positions - STATES[:, :3], axis=1)
    outlying = distance[distance > 0]
    assert len(outlying) / SAMPLES == pytest.approx(0.01, rel=0.2)
    assert outlying.min() >= OUTLIER_DISTANCE[0]
    assert outlying.max() <= OUTLIER_DISTANCE[1]
    assert (~seen).mean() == pytest.approx(0.02, rel=0.15)


def test_without_systematic_errors_the_draws_are_those_of_the_exam_s_records():
    """Numbers from the version that had none; the recordings of the exam follow from them."""
    random = np.random.default_rng(7)
    positions, spins, seen = NOISY.measure(STATES[:4], random)
    np.testing.assert_allclose(positions[0, 2], 0.18774632058868657, rtol=1e-14)
    np.testing.assert_allclose(spins[3, 2], 369.3736043395577, rtol=1e-14)
    assert seen.tolist() == [True, True, False, True]
    assert random.random() == 0.50777223630035


def test_a_field_shifts_true_positions_and_changes_no_other_error():
    without, with_field = (
        cameras.measure(STATES[:100], np.random.default_rng(0))
        for cameras in (NOISY, replace(NOISY, field=FIELD))
    )
    shift = FIELD.errors(STATES[:100, :3])
    np.testing.assert_allclose(with_field[0] - without[0], shift, rtol=0, atol=1e-15)
    assert np.abs(shift).max() > 1e-4
    np.testing.assert_array_equal(with_field[1], without[1])
    np.testing.assert_array_equal(with_field[2], without[2])


def test_rows_of_an_arc_share_an_error_that_adds_to_that_of_each_row():
    def label_errors(arcs, **noise):
        _, spins, _ = measure(arcs, arc_spin_noise=0.03, **noise)
        return (spins - SPIN).reshape(-1, 4, 3)

    arcs = np.repeat(np.arange(SAMPLES // 4), 4)
    errors = label_errors(arcs)
    np.testing.assert_array_equal(errors, np.repeat(errors[:, :1], 4, axis=1))
    of_arcs = errors[:, 0]
    assert of_arcs.std(axis=0) == pytest.approx([0.03 * 500] * 3, rel=0.03)
    following = (of_arcs[1:] * of_arcs[:-1]).mean(axis=0) / of_arcs.var(axis=0)
    assert np.abs(following).max() < 0.05
    both = label_errors(arcs, spin_noise=0.05)
    assert both.std() == pytest.approx(500 * np.hypot(0.05, 0.03), rel=0.02)
    shared = (both[:, 0] * both[:, 1]).mean() / both.var()
    assert shared == pytest.approx(0.03**2 / (0.05**2 + 0.03**2), abs=0.02)
    one_arc = label_errors(None).reshape(-1, 3)
    assert np.ptp(one_arc, axis=0).max() == 0.0 and one_arc.any()


FIELDS = [replace(FIELD, seed=seed) for seed in range(400)]


def places(count):
    """Positions in the playing volume."""
    return np.random.default_rng(0).uniform([-1.5, -3.0, 0.0], [1.5, 3.0, 1.5], (count, 3))


def test_errors_of_the_axes_have_their_size_no_mean_and_no_correlation():
    errors = np.concatenate([field.errors(places(50)) for field in FIELDS])
    size = FIELD.standard_deviation

    assert errors.std(axis=0) == pytest.approx([size] * 3, rel=0.05)
    assert np.abs(errors.mean(axis=0)).max() < 0.1 * size
    assert np.abs(np.corrcoef(errors.T) - np.eye(3)).max() < 0.05


@pytest.mark.parametrize("lengths", [0.5, 1.0, 3.0])
def test_the_correlation_falls_off_with_the_stated_length_in_any_direction(lengths):
    here = places(60)
    there = here + lengths * FIELD.length * np.tile(np.eye(3), (20, 1))
    products = [field.errors(here) * field.errors(there) for field in FIELDS]

    correlation = np.mean(products, axis=(0, 1)) / FIELD.standard_deviation**2
    assert correlation == pytest.approx([np.exp(-(lengths**2) / 2)] * 3, abs=0.07)


def test_a_field_is_a_function_of_position_and_seed_that_its_size_scales():
    here = places(200)
    errors, size = FIELD.errors(here), FIELD.standard_deviation

    one_by_one = np.concatenate([FIELD.errors(place[None]) for place in here])
    np.testing.assert_allclose(errors, one_by_one, rtol=0, atol=1e-15)
    assert np.ptp(errors, axis=0).min() > 0.1 * size
    assert np.abs(FIELDS[1].errors(here) - errors).max() > 0.5 * size
    larger = replace(FIELD, standard_deviation=2 * size)
    np.testing.assert_allclose(larger.errors(here), 2 * errors)
