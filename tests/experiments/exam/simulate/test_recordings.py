"""Recordings have errors of the stated kinds and sizes, the cameras' own and others."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kurtosis

from experiments.exam.simulate.camera_errors import (
    CameraErrors,
    Distortion,
    HeavyTailedScatter,
    LabelErrors,
    Stamps,
    tail_factors,
)
from experiments.exam.simulate.recordings import simulate_trial
from rallygap.models.arena.bounce_scatter import BounceScatter
from tests.experiments.exam.example_trials import NO_SCATTER, NOMINAL, PERFECT, ideal, trial


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


def label_errors(shots=60, **kinds):
    """Errors of all labels in units of the spin, by shot."""
    errors = CameraErrors(labels=LabelErrors(**kinds))
    recordings, truth = simulate_trial(ideal(shots=shots, errors=errors))
    found = []
    for shot, one in enumerate(recordings):
        spins = truth.states(one.label_times)[shot, :, 6:]
        found.append((one.labels - spins) / np.linalg.norm(spins, axis=1, keepdims=True))
    return recordings, truth, found


def test_labels_of_an_arc_a_shot_or_a_session_have_one_error():
    _, _, by_shot = label_errors(shot=0.05)
    assert max(np.ptp(one, axis=0).max() for one in by_shot) < 1e-9
    assert np.std([one[0] for one in by_shot]) == pytest.approx(0.05, rel=0.2)

    _, _, by_session = label_errors(shots=10, session=0.03)
    everything = np.concatenate(by_session)
    assert np.ptp(everything, axis=0).max() < 1e-9
    assert 0.001 < np.abs(everything).max() < 0.12

    recordings, truth, by_arc = label_errors(arc=0.05)
    bounces = zip(truth.bounce_times, recordings, strict=True)
    arcs = [1 + (times < one.times[-1]).sum() for times, one in bounces]
    assert [len(np.unique(one.labels, axis=0)) for one in recordings] == arcs
    assert np.std([one[0] for one in by_arc]) == pytest.approx(0.05, rel=0.2)


@pytest.mark.parametrize("shape", ["gaussian", "radial", "half"])
def test_a_distortion_depends_on_the_place_only_and_has_its_size(shape):
    distortion = Distortion(shape, size=0.003, length=0.8)
    settings = {"shots": 60, "seed": 1002}
    seen, _ = simulate_trial(ideal(errors=CameraErrors(distortion=distortion), **settings))
    true, _ = simulate_trial(ideal(**settings))
    places = np.concatenate([one.positions for one in true])
    errors = np.concatenate([one.positions for one in seen]) - places

    assert np.sqrt((errors**2).mean()) == pytest.approx(0.003, rel=0.5)
    near = np.linalg.norm(places[:, None] - places[None, ::50], axis=2) < 0.02
    first, second = np.nonzero(near)
    assert np.abs(errors[first] - errors[::50][second]).max() < 0.001
    if shape == "half":
        assert np.abs(errors[places[:, 1] < 0]).max() == 0.0


def test_a_gaussian_field_has_its_correlation_length():
    line = np.zeros((2, 3))
    line[1, 0] = 0.8
    fields = np.array([
        Distortion("gaussian", 1.0, 0.8).errors(line, np.random.default_rng(seed))
        for seed in range(400)
    ])  # fmt: skip
    here, there = fields[:, 0].ravel(), fields[:, 1].ravel()

    assert here.std() == pytest.approx(1.0, rel=0.1)
    assert (here * there).mean() == pytest.approx(np.exp(-0.5), abs=0.1)


def test_heavy_tails_of_positions_and_bounces_keep_the_standard_deviation():
    factors = tail_factors(200_000, 4.0, np.random.default_rng(0))
    errors = factors * np.random.default_rng(1).standard_normal(len(factors))
    assert errors.std() == pytest.approx(1.0, rel=0.05)
    assert kurtosis(errors) > 3.0

    noise = replace(PERFECT, position_noise=0.003)
    errors = CameraErrors(tails=3.0)
    asked = trial(shots=40, cameras=noise, scatter=NO_SCATTER, errors=errors)
    seen, truth = simulate_trial(asked)
    off = [one.positions - truth.states(one.times)[shot, :, :3] for shot, one in enumerate(seen)]
    assert kurtosis(np.concatenate(off).ravel()) > 1.5
    contacts = truth.shots.contacts
    bounces = [np.repeat(of[:1, 0], 3000, axis=0) for of in (contacts.before, contacts.after)]
    normal, heavy = (
        kurtosis(scatter.apply(NOMINAL, *bounces, np.random.default_rng(0))[:, 5])
        for scatter in (BounceScatter(0.01, 0.05), HeavyTailedScatter(0.01, 0.05, 3.0))
    )
    assert heavy > normal + 1.5


def test_stamps_are_rounded_or_jittered_and_rise():
    for stamps in (Stamps(rounding=0.005), Stamps(jitter=0.002)):
        recordings, _ = simulate_trial(trial(shots=20, errors=CameraErrors(stamps=stamps)))
        exact, _ = simulate_trial(trial(shots=20))
        times = np.concatenate([one.times for one in recordings])

        assert all((np.diff(one.times) > 0).all() for one in recordings)
        lost = sum(len(one.times) for one in exact) - len(times)
        assert 0 <= lost < 0.2 * len(times)
        if stamps.rounding:
            assert times / 0.005 == pytest.approx(np.round(times / 0.005), abs=1e-9)
        else:
            steps = np.concatenate([np.diff(one.times) for one in recordings])
            assert steps[steps < 0.0075].std() == pytest.approx(np.sqrt(2 / 3) * 0.002, rel=0.15)
