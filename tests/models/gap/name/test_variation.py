"""Variation: a parameter that drifts, or differs between shots or sides, is found alone."""

import numpy as np
import pytest

from experiments.exam.interface import shots_of
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial, Variation
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.naming import name
from rallygap.models.gap.name.variation import variations
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured


def session(values, effect="drag", parameter="cd"):
    """Shots of a session, each with its own value of a parameter."""
    shots = []
    for number, value in enumerate(values):
        truth = NOMINAL.amended(effect, **{parameter: value})
        shots.append(measured(truth, count=2, seed=number)[[number % 2]])
    there = [(one, one.valid[0], one.labelled[0]) for one in shots]
    return Shots.from_arrays(
        [one.times[0, valid] for one, valid, _ in there],
        [one.positions[0, valid] for one, valid, _ in there],
        [one.labels[0, labelled] for one, _, labelled in there],
        [one.label_times[0, labelled] for one, _, labelled in there],
    )


def found(shots):
    return {one.kind: one for one in variations(name(shots, Question(NOMINAL, SETTINGS)))}


def test_a_drag_that_drifts_over_the_session_is_found_with_its_size():
    drift = found(session(np.linspace(0.45, 0.55, 40)))["drift"]
    assert drift.identity == "drag.cd"
    assert drift.interval[0] < 0.1 < drift.interval[1]
    assert drift.size == pytest.approx(0.1, rel=0.2)


def test_balls_that_differ_in_drag_are_found_with_their_spread():
    between = found(session(0.5 + 0.05 * np.random.default_rng(1).standard_normal(40)))
    assert between["between_shots"].identity == "drag.cd"
    assert between["between_shots"].size == pytest.approx(0.05, rel=0.3)


def test_a_cause_that_all_shots_have_is_no_variation():
    assert found(session(np.full(40, 0.45))) == {}


@pytest.mark.parametrize("by_side", [True, False])
def test_a_draught_in_half_of_the_room_is_found_with_its_size(by_side):
    wind, causes = Hypothesis("wind", "x"), {"wind": {"x": 0.3}}
    variation = Variation("place", wind) if by_side else None
    recordings, _ = simulate_trial(
        Trial("", NOMINAL, causes=causes, variation=variation, shots=60, seed=5)
    )
    found = name(shots_of(recordings), Question(NOMINAL, SETTINGS))
    if not by_side:
        assert variations(found) == ()
        return
    (difference,) = variations(found)
    assert (difference.identity, difference.kind) == ("wind.x", "by_side")
    assert difference.size == pytest.approx(0.3, rel=0.3)
    assert difference.interval[0] < 0.3 < difference.interval[1]
    assert found.distortion is None  # it is no error of the cameras
    assert wind in [found.explainer.evidence.columns[k] for k in found.explanation.causes]
