"""The removable gap: nothing is left by a perfect simulator, and half by one half as wrong."""

import pytest

from models.exam.scoring.removable_gap import RemovableGap
from models.exam.simulate.recordings import held
from tests.models.exam.halls import NOMINAL, trial

CAUSES = {"wind": {"x": 0.4}, "clock_rate": {"d": 0.004}}


def gap(**settings):
    _, truth = held(trial(shots=5, **settings))
    return RemovableGap(truth), truth.trial.simulator


def test_a_perfect_simulator_leaves_nothing_scatter_and_noise_aside():
    found, true = gap(causes=CAUSES)

    assert found.left(true) == pytest.approx(0.0, abs=1e-6)
    assert found.left(NOMINAL) > 3.0


def test_what_is_left_is_proportional_to_how_wrong_a_simulator_is():
    found, _ = gap(causes={"wind": {"x": 0.4}})
    half = NOMINAL.amended("wind", x=0.2)

    assert found.left(half) == pytest.approx(found.left(NOMINAL) / 2, rel=0.05)


def test_the_best_size_of_another_form_leaves_little():
    found, equivalent = gap(causes={"wind": {"x": 0.4}}, world="independent")

    assert 0.0 < found.left(equivalent) < 0.3 * found.left(NOMINAL)
