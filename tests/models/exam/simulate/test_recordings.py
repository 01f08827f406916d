"""Recordings have errors of the stated kinds and sizes."""

from dataclasses import replace

import numpy as np
import pytest

from models.exam.simulate.independent_ball import IndependentBall
from models.exam.simulate.recordings import simulate_trial
from models.exam.simulate.trial import CAMERAS
from tests.models.exam.example_trials import PERFECT, ideal, trial


def true_paths(recordings, truth):
    """The true states of every shot at the times of its recording."""
    longest = max(len(recording.times) for recording in recordings)
    times = np.array([np.resize(r.times, longest) for r in recordings])
    for shot, recording in enumerate(recordings):
        times[shot, len(recording.times) :] = recording.times[-1]
    paths = truth.states(times)
    return [path[: len(r.times)] for path, r in zip(paths, recordings, strict=True)]


def errors(recordings, truth):
    """Position errors of every shot, NaN where something else was taken for the ball."""
    found = []
    for recording, path in zip(recordings, true_paths(recordings, truth), strict=True):
        error = recording.positions - path[:, :3]
        error[np.linalg.norm(error, axis=1) > 0.03] = np.nan
        found.append(error)
    return found


@pytest.fixture(scope="module")
def noisy():
    return simulate_trial(trial(shots=150, seed=4, cameras=replace(CAMERAS, dropouts=0.0)))


def test_noise_has_the_stated_size_and_share_of_outliers(noisy):
    error = np.concatenate(errors(*noisy))

    assert np.nanstd(error) == pytest.approx(0.003, rel=0.03)
    assert np.isnan(error[:, 0]).mean() == pytest.approx(0.01, abs=0.003)


def test_part_of_the_noise_is_slow(noisy):
    """Its correlation is the slow share times exp(-lag / time)."""
    for lag in (1, 10):
        products = [e[lag:] * e[:-lag] for e in errors(*noisy) if len(e) > lag]
        correlation = np.nanmean(np.concatenate(products)) / 0.003**2
        assert correlation == pytest.approx(0.2 * np.exp(-lag * 0.005 / 0.05), abs=0.03)


def test_frames_come_at_200_hz_with_jitter(noisy):
    steps = np.concatenate([np.diff(recording.times) for recording in noisy[0]])

    assert steps.mean() == pytest.approx(0.005, rel=1e-3)
    assert steps.std() == pytest.approx(3e-4 * np.sqrt(2 / 3), rel=0.05)
    assert (steps > 0).all()


def test_some_frames_are_missed():
    settings = {"shots": 60, "seed": 4}
    few, _ = simulate_trial(trial(cameras=replace(CAMERAS, dropouts=0.2), **settings))
    every, _ = simulate_trial(trial(cameras=replace(CAMERAS, dropouts=0.0), **settings))

    missed = 1 - sum(len(r.times) for r in few) / sum(len(r.times) for r in every)

    assert missed == pytest.approx(0.2, abs=0.02)


def test_labels_err_by_their_share_of_the_spin(noisy):
    recordings, truth = noisy
    shares = []
    for recording, path in zip(recordings, true_paths(recordings, truth), strict=True):
        spin = path[:, 6:]
        shares.append((recording.labels - spin) / np.linalg.norm(spin, axis=1, keepdims=True))

    assert np.std(np.concatenate(shares)) == pytest.approx(0.05, rel=0.03)


@pytest.mark.parametrize(("labels", "count"), [("none", 0), ("per_shot", 1)])
def test_labels_come_as_the_trial_says(labels, count):
    recordings, _ = simulate_trial(trial(shots=10, spin_labels=labels))

    assert all(recording.labels.shape == (count, 3) for recording in recordings)
    assert all(recording.label_times.shape == (count,) for recording in recordings)


def test_coarse_time_stamps_are_rounded():
    recordings, _ = simulate_trial(trial(shots=10, time_resolution=0.001))

    stamps = np.concatenate([recording.times for recording in recordings]) * 1000

    assert stamps == pytest.approx(np.round(stamps), abs=1e-9)


def test_perfect_cameras_show_the_true_path():
    recordings, truth = simulate_trial(ideal(shots=20))

    assert max(np.abs(e).max() for e in errors(recordings, truth)) < 1e-9


def test_the_sensors_faults_act_on_scattered_balls():
    hidden = {"position_scale": {"s": 0.01}, "clock_rate": {"d": 0.02}, "spin_gain": {"s": 0.1}}
    recordings, truth = simulate_trial(trial(shots=20, cameras=PERFECT, causes=hidden))

    for shot, recording in enumerate(recordings):
        path = truth.states(recording.times / 1.02)[shot]
        assert recording.positions == pytest.approx(1.01 * path[:, :3], abs=1e-9)
        assert recording.labels == pytest.approx(1.1 * path[:, 6:], abs=1e-6)


def test_a_lag_with_speed_shows_where_the_ball_was():
    recordings, truth = simulate_trial(
        ideal(shots=5, causes={"speed_dependent_latency": {"tau": 0.001}})
    )

    for shot, recording in enumerate(recordings):
        speed = np.linalg.norm(truth.states(recording.times)[shot, :, 3:6], axis=1)
        seen = recording.times - 0.001 * speed
        order = np.argsort(seen)
        path = truth.states(seen[order])[shot, :, :3]
        assert recording.positions[order] == pytest.approx(path, abs=1e-9)


def test_the_labels_of_a_shot_are_all_flipped_or_none():
    hidden = {"spin_sign_flip": {"share": 0.3}}
    recordings, truth = simulate_trial(ideal(shots=200, causes=hidden))

    signs = [
        np.sign((recording.labels * path[:, 6:]).sum(axis=1))
        for recording, path in zip(recordings, true_paths(recordings, truth), strict=True)
    ]

    assert all(len(set(sign)) == 1 for sign in signs)
    assert np.mean([sign[0] < 0 for sign in signs]) == pytest.approx(0.3, abs=0.08)


def test_without_causes_both_dynamics_give_the_same_recordings():
    ours, _ = simulate_trial(ideal(shots=60, dynamics="catalogue", seed=7))
    others, truth = simulate_trial(ideal(shots=60, dynamics="independent", seed=7))

    assert isinstance(truth.shots.ball, IndependentBall)
    for one, other in zip(ours, others, strict=True):
        assert (one.times == other.times).all()
        assert np.abs(one.positions - other.positions).max() < 1e-6


@pytest.mark.parametrize("dynamics", ["catalogue", "independent"])
def test_a_trial_is_the_same_every_time(dynamics):
    hidden = {"lift_saturation": {"kappa": 0.5}}
    (first, _), (again, _), (other, _) = (
        simulate_trial(trial(shots=15, dynamics=dynamics, causes=hidden, seed=seed))
        for seed in (1, 1, 2)
    )

    for one, same in zip(first, again, strict=True):
        assert (one.positions == same.positions).all()
        assert (one.labels == same.labels).all()
    assert len(first[0].times) != len(other[0].times) or (first[0].times != other[0].times).all()


def test_hidden_causes_do_not_change_the_launches():
    _, clean = simulate_trial(trial(shots=15))
    _, windy = simulate_trial(trial(shots=15, causes={"wind": {"x": 1.0}}))

    assert (clean.shots.launches == windy.shots.launches).all()
