"""Sizes: those that the workflow finds itself, from what it cannot know beforehand."""

from dataclasses import replace

import numpy as np
import pytest

from models.exam.answer import shots_of
from models.exam.design.detectable_sizes import SIGNS, Sight
from models.exam.design.trial import CAMERAS
from models.exam.simulate.recordings import held
from models.gap.fit.refit import refit
from models.gap.hypotheses import Hypothesis
from models.gap.inference.score_test import Evidence
from tests.models.exam.halls import NOMINAL, trial

WIND, GRAVITY, BUOYANCY = ("wind", "x"), ("gravity", "g"), ("buoyancy", "b")
ADDED_MASS = ("added_mass", "c")


def sight(**settings):
    return Sight.of(trial(shots=30, seed=1001, **settings))


@pytest.fixture(scope="module")
def usual():
    return sight()


def test_they_are_what_the_workflow_finds_with_noise_and_scatter_estimated(usual):
    recordings, _ = held(trial(shots=30, seed=1001))
    fit = refit(shots_of(recordings), NOMINAL, ())
    found = Evidence.of(fit.linear, fit.components)

    for name in (WIND, GRAVITY, ("drag", "cd"), ("spin_decay", "c"), ("table_height", "h")):
        k = found.columns.index(Hypothesis(*name))
        expected = found.detectable(k, [j for j in found.free if j != k])
        assert usual.detectable((name,)) == pytest.approx([expected], rel=0.15)


def test_causes_change_nothing(usual):
    assert sight(causes={"wind": {"x": 1.0}}).detectable((WIND,)) == usual.detectable((WIND,))


def test_noise_makes_them_larger(usual):
    noisy = sight(cameras=replace(CAMERAS, position_noise=0.010))

    assert noisy.detectable((WIND,))[0] > 1.5 * usual.detectable((WIND,))[0]


def test_what_cannot_be_told_from_the_nominal_numbers_can_be_seen_all_the_same(usual):
    (size,) = usual.detectable((BUOYANCY,))

    assert np.isfinite(size)
    assert "gravity" in usual.alike(BUOYANCY, 3 * size)


def test_look_alikes_are_those_that_leave_nothing_to_detect(usual):
    (gravity,) = usual.detectable((GRAVITY,))
    (wind,) = usual.detectable((WIND,))

    assert "buoyancy" in usual.alike(GRAVITY, 3 * gravity)
    assert "buoyancy" in usual.alike(GRAVITY, 100 * gravity)
    assert usual.alike(WIND, 0.5 * wind) != ()
    assert usual.alike(WIND, 100 * wind) == ()


def test_two_nominal_numbers_together_may_stand_in_for_what_is_missing(usual):
    (size,) = usual.detectable((ADDED_MASS,))

    assert usual.alike(ADDED_MASS, 3 * size) == ("drag", "gravity")
    assert usual.alike(ADDED_MASS, 30 * size) == ()


def test_a_withheld_effect_must_stand_out_of_all_others(usual):
    withheld = replace(usual, withheld=("wind",))

    assert withheld.detectable((WIND,))[0] > usual.detectable((WIND,))[0]
    assert replace(usual, withheld=("buoyancy",)).detectable((BUOYANCY,)) == [np.inf]


def test_labels_must_be_there_to_read_backwards(usual):
    unlabelled = sight(spin_labels="none")

    assert usual.detectable((SIGNS,)) == [4 / 30]
    assert unlabelled.detectable((SIGNS, ("spin_gain", "s"))) == [np.inf, np.inf]
    assert usual.alike(SIGNS, 0.1) == ()
