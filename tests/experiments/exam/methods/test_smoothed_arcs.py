"""Smoothed arcs, against the true states."""

import numpy as np
import pytest

from experiments.exam.interface import shots_of
from experiments.exam.methods.smoothed_arcs import SmoothedArcs
from experiments.exam.simulate.recordings import simulate_trial
from tests.experiments.exam.example_trials import NOMINAL, ideal


@pytest.fixture(scope="module")
def truth():
    recordings, truth = simulate_trial(ideal(shots=12, seed=1003, causes={"wind": {"x": 0.2}}))
    return SmoothedArcs.of(shots_of(recordings), NOMINAL), truth


def test_arcs_lie_between_bounces_and_leave_none_of_them_out(truth):
    arcs, truth = truth
    times = truth.shots.contacts.time
    seen = times < truth.durations[:, None] - 0.06
    ends = arcs.ends[np.isfinite(arcs.ends)]
    assert np.sort(ends) == pytest.approx(np.sort(times[seen]), abs=2e-3)
    assert (arcs.shots.times[:, 0] > arcs.starts).all()
    assert (arcs.shots.times[:, -1] < arcs.ends).all()


def test_smoothed_states_are_the_true_ones_although_the_simulator_is_wrong(truth):
    smoothed, truth = truth
    scale = np.linspace(-1.0, 1.0, 5)
    for arc, shot in enumerate(smoothed.parents):
        times = smoothed.times(scale)
        expected = truth.states(np.broadcast_to(times[arc], (12, 5)))[shot]
        error = np.abs(smoothed.smooth(times)[arc] - expected)
        assert error[:, :3].max() < 1e-3
        assert error[:, 3:6].max() < 0.05
