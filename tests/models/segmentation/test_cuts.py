"""Cuts of simulated rallies against the truth, and of real ones against what can be seen."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from rallygap.models.segmentation.cuts import cut, flight_residuals
from rallygap.models.segmentation.flight import DRAG
from rallygap.models.segmentation.settings import SegmentSettings
from tests.models.segmentation.rallies import scores, simulated_rally

SETTINGS = SegmentSettings()
T = 0.005 * np.arange(100)
ALL = np.ones(100, dtype=bool)


def cut_rallies(number, first_seed, **measured):
    seeds = range(first_seed, first_seed + number)
    rallies = [simulated_rally(np.random.default_rng(seed), **measured) for seed in seeds]
    return [(rally, cut(rally.t, rally.x, SETTINGS)) for rally in rallies]


def contacts(pairs):
    return [(rally, list(cuts.contacts.values())) for rally, cuts in pairs]


@pytest.fixture(scope="module")
def pairs():
    return cut_rallies(30, 0)


@pytest.mark.parametrize("kind", ["racket", "table"])
def test_contacts_are_found_and_nothing_else(pairs, kind):
    precision, recall = scores(contacts(pairs), kind)
    assert precision >= 0.995
    assert recall >= 0.993


@pytest.mark.slow
def test_contacts_are_found_in_poor_measurements():
    poor = contacts(cut_rallies(100, 1000, noise=0.0045, outliers=0.05, bursts=2.0))
    assert min(*scores(poor, "racket"), *scores(poor, "table")) >= 0.98


def test_contact_times_and_places_are_right(pairs):
    errors, heights = [], []
    for rally, found in contacts(pairs):
        true = np.array([time for time, _ in rally.contacts])
        errors += [np.abs(true - contact.time).min() for contact in found]
        heights += [contact.position[2] for contact in found if contact.kind == "table"]
    assert np.median(errors) < 0.0005
    assert np.median(heights) == pytest.approx(0.02, abs=0.001)


def test_outliers_are_marked_and_velocities_are_right_there_too(pairs):
    true = np.concatenate([rally.outlier for rally, _ in pairs])
    marked = np.concatenate([cuts.outlier for _, cuts in pairs])
    assert marked[true].mean() > 0.99
    assert marked[~true].mean() < 0.005
    off = np.concatenate([cuts.velocity - rally.velocity for rally, cuts in pairs])
    error = np.linalg.norm(off, axis=1)
    assert np.median(error) < 0.05
    assert np.median(error[true]) < 0.05
    assert np.percentile(error, 99) < 0.5


def test_cuts_do_not_depend_on_when_or_on_which_side(pairs):
    rally, one = pairs[0]
    other = cut(rally.t + 64.0, rally.x * [-1, 1, 1], SETTINGS)
    np.testing.assert_array_equal(one.flight, other.flight)
    np.testing.assert_allclose(one.velocity, other.velocity * [-1, 1, 1], atol=1e-6)
    times = [[contact.time for contact in cuts.contacts.values()] for cuts in (one, other)]
    np.testing.assert_allclose(times[0], np.array(times[1]) - 64.0, atol=1e-6)


def parabola():
    t = 0.005 * np.arange(60)
    return t, np.stack([0 * t, 4 * t, 0.3 + 2 * t - 4.905 * t**2], axis=1)


def test_gap_begins_a_flight_without_a_contact_and_a_step_of_the_measurement_is_a_residual():
    t, x = parabola()
    keep = (t < 0.1) | (t > 0.1 + SETTINGS.longest_gap)
    cuts = cut(t[keep], x[keep], SETTINGS)
    np.testing.assert_array_equal(cuts.flight, (t > 0.1)[keep])
    assert cuts.contacts == {}
    x[30:, 0] += 0.08
    cuts = cut(t, x, SETTINGS)
    assert cuts.flights == 1
    assert np.sqrt(np.mean(cuts.residual**2)) > SETTINGS.unbroken_residual


@pytest.mark.parametrize(
    ("position", "before", "after", "kind"),
    [
        ([0.0, 0.8, 0.02], [0.0, 16.0, -0.6], [0.0, 16.0, 0.5], "table"),
        ([0.0, 0.01, 0.16], [0.0, 4.7, 0.4], [0.0, 3.9, 0.8], "net"),
    ],
)
def test_light_touch_of_table_or_net_is_a_contact(position, before, after, kind):
    t = 0.005 * np.arange(-60, 61)[:, None]
    x = position + np.where(t < 0, before, after) * t - [0, 0, 4.905] * t**2
    (contact,) = cut(t[:, 0], x, SETTINGS).contacts.values()
    assert contact.kind == kind
    assert contact.speed_change < SETTINGS.smallest_jump
    assert contact.time == pytest.approx(0, abs=0.01)


def test_samples_too_few_for_a_path_are_in_no_flight():
    t = np.array([0.0, 0.005, *np.arange(0.5, 0.6, 0.005)])
    x = np.stack([0 * t, 4 * t, 0 * t], axis=1)
    cuts = cut(t, x, SETTINGS)
    assert cuts.flight[:2].tolist() == [-1, -1]
    assert np.isnan(cuts.velocity[:2]).all()
    assert set(cuts.flight[2:]) == {0}


def test_residuals_of_a_flight_are_those_of_outliers_and_of_missed_contacts_alone():
    def motion(_, state):
        return [*state[3:], *([0.0, 2.0, -12.81] - DRAG * np.linalg.norm(state[3:]) * state[3:])]

    begin = [0, -1, 0.3, 0.5, 6.0, 2.0]
    states = solve_ivp(motion, (0, 0.5), begin, t_eval=T, rtol=1e-10, atol=1e-12).y.T
    x, velocity = states[:, :3], states[:, 3:]
    assert flight_residuals(T, x, velocity, ALL).max() < 1e-4
    outlier = np.arange(100) == 40
    off = x + outlier[:, None] * [0.0, 0.3, 0.4]
    errors = flight_residuals(T, off, velocity, ~outlier)
    np.testing.assert_allclose(errors, np.where(outlier, 0.5, 0), atol=1e-4)
    x[50:] += (T[50:, None] - T[50]) * [0, -1.0, 4.0]
    assert np.sqrt(np.mean(flight_residuals(T, x, velocity, ALL) ** 2)) > 0.03


@pytest.mark.real
def test_every_real_stroke_bounces_once(real_data):
    # Each recording shows one stroke from just after the racket to just before the next, and one
    # bounce; in one of them the ball touches the net.
    files = sorted((real_data / "tt3d").glob("*.csv"))
    assert files
    for file in files:
        recording = pd.read_csv(file)
        t, x = recording["Timestamp"].to_numpy(), recording[["X", "Y", "Z"]].to_numpy()
        kinds = [contact.kind for contact in cut(t, x, SETTINGS).contacts.values()]
        assert kinds == (["table", "net"] if file.stem == "125" else ["table"]), file.name
