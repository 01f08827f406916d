"""The camera field: a smooth, fixed error of position with its stated size and length."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.arena.cameras import CameraField
from rallygap.models.arena.truth import draw_truth

DEVIATION, LENGTH = 0.0015, 0.8  # m
FIELDS = [CameraField(DEVIATION, LENGTH, seed) for seed in range(400)]
PLAYING_VOLUME = np.array([[-1.5, -3.0, 0.0], [1.5, 3.0, 1.5]])  # m


def places(count):
    """Positions in the playing volume."""
    return np.random.default_rng(0).uniform(*PLAYING_VOLUME, (count, 3))


def test_errors_of_the_axes_have_their_size_no_mean_and_no_correlation():
    errors = np.concatenate([field.errors(places(50)) for field in FIELDS])

    assert errors.std(axis=0) == pytest.approx([DEVIATION] * 3, rel=0.05)
    assert np.abs(errors.mean(axis=0)).max() < 0.1 * DEVIATION
    assert np.abs(np.corrcoef(errors.T) - np.eye(3)).max() < 0.05


@pytest.mark.parametrize("lengths", [0.1, 0.5, 1.0, 3.0])
def test_the_correlation_falls_off_with_the_stated_length_in_any_direction(lengths):
    here = places(60)
    there = here + lengths * LENGTH * np.tile(np.eye(3), (20, 1))

    products = [field.errors(here) * field.errors(there) for field in FIELDS]

    correlation = np.mean(products, axis=(0, 1)) / DEVIATION**2
    assert correlation == pytest.approx([np.exp(-(lengths**2) / 2)] * 3, abs=0.07)


def test_a_field_is_a_function_of_the_position():
    field, here = FIELDS[0], places(20)

    one_by_one = np.concatenate([field.errors(place[None]) for place in here])

    np.testing.assert_allclose(field.errors(here), one_by_one, rtol=0, atol=1e-15)
    assert np.ptp(field.errors(here), axis=0).min() > 0.1 * DEVIATION


def test_another_seed_is_another_field_and_the_deviation_only_scales_it():
    field, here = FIELDS[0], places(2000)
    errors = field.errors(here)

    other, larger = (replace(field, seed=1), replace(field, standard_deviation=2 * DEVIATION))

    assert np.abs(other.errors(here) - errors).max() > 0.5 * DEVIATION
    np.testing.assert_allclose(larger.errors(here), 2 * errors)


def test_arenas_of_different_seeds_have_different_fields():
    fields = [draw_truth(seed).camera_field for seed in range(20)]

    assert len({field.seed for field in fields}) == len(fields)
    for field in fields:
        assert field.standard_deviation == pytest.approx(DEVIATION, rel=0.2)
        assert field.length == pytest.approx(LENGTH, rel=0.2)
