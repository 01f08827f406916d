"""Robustness groups have the conditions that their names say, and clean sets of each."""

import numpy as np
import pytest

from experiments.exam.design.parameters import family
from experiments.exam.design.question import MULTIPLE
from experiments.exam.design.robustness import GROUPS, VARYING, robustness
from tests.experiments.exam.example_trials import NOMINAL

QUESTIONS = list(robustness(NOMINAL, seed=0))


def group(name):
    return [question for question in QUESTIONS if question.group == name]


def errors(name):
    return [question.trial.errors for question in group(name)]


@pytest.mark.parametrize("name", GROUPS)
def test_a_fifth_of_every_group_is_clean_and_a_third_has_independent_dynamics(name):
    questions = group(name)
    clean = [question for question in questions if not question.differences]

    assert len(questions) >= 60
    assert len(clean) == len(questions) / 5
    assert {question.cell for question in clean} == {question.cell for question in questions}
    assert all(question.trial.simulator == question.trial.nominal for question in clean)
    independent = [question.trial.dynamics == "independent" for question in questions]
    assert np.mean(independent) == pytest.approx(1 / 3, abs=0.02)


def test_only_varying_groups_have_a_cause_that_varies():
    for question in QUESTIONS:
        varies = question.trial.variation is not None
        assert varies == (question.group in VARYING and bool(question.hidden))


def test_sensor_errors_are_of_all_kinds():
    labels = [one.labels for one in errors("label_kind")]
    stamps = [one.stamps for one in errors("time_stamps")]
    kinds = np.eye(4, dtype=bool)[:, 1:]  # none, or one
    assert {(bool(e.arc), bool(e.shot), bool(e.session)) for e in labels} == set(map(tuple, kinds))
    assert {stamp.rounding > 0 for stamp in stamps} == {stamp.jitter > 0 for stamp in stamps}
    multiples = {(q.trial.errors.distortion.shape, q.multiple) for q in group("distortion")}
    assert len(multiples) == 6


def test_several_causes_are_of_different_families():
    hidden = [question.hidden for question in group("several") if question.hidden]

    assert {len(some) for some in hidden} == {3, 4, 5, 6}
    assert all(len({family(one) for one in some}) == len(some) for some in hidden)
    assert min(question.multiple for question in group("several")) >= MULTIPLE


def test_a_nominal_simulator_that_is_far_off_differs_in_a_parameter_and_an_effect():
    for question in group("far_off"):
        if question.hidden:
            missing, wrong = question.differences
            assert question.trial.base.effects.keys() == NOMINAL.effects.keys()
            assert wrong.value(question.trial.base) == wrong.value(NOMINAL)
            assert wrong.value(question.trial.nominal) != wrong.value(NOMINAL)
            assert not missing.listed(question.trial.nominal)
