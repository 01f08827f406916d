"""The removable gap is zero for a perfect simulator, and linear in the size of an error."""

import pytest

from rallygap.models.exam.scoring.removable_gap import RemovableGap
from rallygap.models.exam.simulate.recordings import simulate_trial
from tests.models.exam.example_trials import NOMINAL, trial

CAUSES = {"wind": {"x": 0.4}, "clock_rate": {"d": 0.004}}


def gap(**settings):
    _, truth = simulate_trial(trial(shots=5, **settings))
    return RemovableGap(truth), truth.trial.simulator


def test_a_perfect_simulator_leaves_nothing_scatter_and_noise_aside():
    found, true = gap(causes=CAUSES)

    assert found.remaining(true) == pytest.approx(0.0, abs=1e-6)
    assert found.remaining(NOMINAL) > 3.0


def test_what_is_left_is_proportional_to_how_wrong_a_simulator_is():
    found, _ = gap(causes={"wind": {"x": 0.4}})
    half = NOMINAL.amended("wind", x=0.2)

    assert found.remaining(half) == pytest.approx(found.remaining(NOMINAL) / 2, rel=0.05)


def test_the_best_size_of_another_form_leaves_little():
    found, equivalent = gap(causes={"wind": {"x": 0.4}}, dynamics="independent")

    assert 0.0 < found.remaining(equivalent) < 0.3 * found.remaining(NOMINAL)
