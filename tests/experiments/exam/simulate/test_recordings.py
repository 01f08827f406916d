"""Recordings have errors of the stated kinds and sizes."""

import numpy as np
import pytest

from experiments.exam.simulate.recordings import simulate_trial
from tests.experiments.exam.example_trials import PERFECT, ideal, trial


def test_frames_come_at_200_hz_with_jitter():
    recordings, _ = simulate_trial(ideal(shots=150))
    steps = np.concatenate([np.diff(recording.times) for recording in recordings])

    assert steps.mean() == pytest.approx(0.005, rel=1e-3)
    assert steps.std() == pytest.approx(3e-4 * np.sqrt(2 / 3), rel=0.05)
    assert (steps > 0).all()


@pytest.mark.parametrize(("labels", "count"), [("none", 0), ("per_shot", 1)])
def test_labels_come_as_the_trial_says_and_coarse_time_stamps_are_rounded(labels, count):
    recordings, _ = simulate_trial(trial(shots=10, spin_labels=labels, time_resolution=0.001))

    assert all(recording.labels.shape == (count, 3) for recording in recordings)
    assert all(recording.label_times.shape == (count,) for recording in recordings)
    stamps = np.concatenate([recording.times for recording in recordings]) * 1000
    assert stamps == pytest.approx(np.round(stamps), abs=1e-9)


def test_the_sensors_faults_act_on_scattered_balls():
    hidden = {"position_scale": {"s": 0.01}, "clock_rate": {"d": 0.02}, "spin_gain": {"s": 0.1}}
    recordings, truth = simulate_trial(trial(shots=20, cameras=PERFECT, causes=hidden))

    for shot, recording in enumerate(recordings):
        path = truth.states(recording.times / 1.02)[shot]
        assert recording.positions == pytest.approx(1.01 * path[:, :3], abs=1e-9)
        assert recording.labels == pytest.approx(1.1 * path[:, 6:], abs=1e-6)


def test_a_lag_with_speed_shows_where_the_ball_was():
    lag = {"speed_dependent_latency": {"tau": 0.001}}
    recordings, truth = simulate_trial(ideal(shots=5, causes=lag))
    for shot, recording in enumerate(recordings):
        speed = np.linalg.norm(truth.states(recording.times)[shot, :, 3:6], axis=1)
        seen = recording.times - 0.001 * speed
        order = np.argsort(seen)
        path = truth.states(seen[order])[shot, :, :3]
        assert recording.positions[order] == pytest.approx(path, abs=1e-9)


def test_the_labels_of_a_shot_are_all_flipped_or_none():
    recordings, truth = simulate_trial(ideal(shots=100, causes={"spin_sign_flip": {"share": 0.3}}))
    signs = [
        np.sign((one.labels * truth.states(one.times)[shot, :, 6:]).sum(axis=1))
        for shot, one in enumerate(recordings)
    ]
    assert all(len(set(sign)) == 1 for sign in signs)
    assert np.mean([sign[0] < 0 for sign in signs]) == pytest.approx(0.3, abs=0.08)


@pytest.mark.parametrize("dynamics", ["catalogue", "independent"])
def test_a_trial_is_the_same_every_time(dynamics):
    hidden = {"lift_saturation": {"kappa": 0.5}}
    (first, truth), (again, _), (other, _) = (
        simulate_trial(trial(shots=15, dynamics=dynamics, causes=hidden, seed=seed))
        for seed in (1, 1, 2)
    )
    for one, same in zip(first, again, strict=True):
        assert (one.positions == same.positions).all()
        assert (one.labels == same.labels).all()
    assert not np.array_equal(first[0].times, other[0].times)
    _, clean = simulate_trial(trial(shots=15, seed=1))
    assert (clean.shots.launches == truth.shots.launches).all()  # whatever is hidden
