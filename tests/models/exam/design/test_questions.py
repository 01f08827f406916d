"""The design: complete, balanced, and a pure function of its seed."""

from collections import Counter

import numpy as np
import pytest

from models.ball.catalogue import catalogue
from models.exam.design.questions import LEFT_OUT, Counts, exam, family, hideable, spread
from tests.models.exam.halls import NOMINAL

QUESTIONS = exam(NOMINAL, seed=0)


SMALL = 1e-5


def small(_trial, names):
    return [SMALL] * len(names)


def group(name):
    """The questions of a group, of which there are some."""
    found = [question for question in QUESTIONS if question.group == name]
    assert found, name
    return found


def test_it_has_the_sizes_of_a_full_exam():
    sizes = Counter(question.group for question in QUESTIONS)

    assert 1050 <= sizes.pop("sweep") <= 1150
    assert sizes.pop("clean") == 500
    assert sum(sizes.values()) == 300


def test_at_least_a_quarter_of_each_group_is_from_the_independent_world():
    for name in {question.group for question in QUESTIONS}:
        worlds = [question.trial.world == "independent" for question in group(name)]
        assert np.mean(worlds) >= 0.25


def test_every_parameter_is_asked_in_every_cell_unless_there_is_a_reason():
    asked = Counter(question.asked[0] for question in group("sweep"))

    assert set(asked) == set(hideable())
    assert len(set(asked.values())) == 1
    left_out = {effect for effect in catalogue() if effect not in {name for name, _ in asked}}
    assert left_out == set(LEFT_OUT)
    assert "time_offset" in LEFT_OUT


def test_sweeps_change_one_thing_at_a_time():
    cells = {(q.multiple, q.trial.shots, q.trial.cameras.position_noise) for q in group("sweep")}

    base = (3.0, 100, 0.003)
    changed = [sum(a != b for a, b in zip(cell, base, strict=True)) for cell in cells]
    assert len(cells) == 10
    assert sorted(changed) == [0] + [1] * 9


def test_names_and_seeds_are_unique():
    trials = [question.trial for question in QUESTIONS]

    assert len({trial.name for trial in trials}) == len(trials)
    assert len({trial.seed for trial in trials}) == len(trials)


def test_the_same_seed_gives_the_same_exam_and_another_one_another():
    assert exam(NOMINAL, seed=0) == QUESTIONS
    assert exam(NOMINAL, seed=1) != QUESTIONS


def test_a_trials_seed_does_not_depend_on_how_many_others_there_are():
    fewer = exam(NOMINAL, seed=0, counts=Counts(base=1, sweep=1, clean=10))
    seeds = {question.trial.name: question.trial.seed for question in QUESTIONS}

    sweeps = [q.trial for q in fewer if q.group in ("sweep", "clean")]
    assert len(sweeps) == 34 * 10 + 10
    assert all(seeds[trial.name] == trial.seed for trial in sweeps)


def test_a_posed_question_hides_a_multiple_of_what_can_be_seen():
    for question in group("sweep")[::25]:
        trial = question.posed(small)
        (cause,) = trial.hidden
        assert (cause.effect, cause.parameter) == question.asked[0]
        assert abs(cause.value - cause.nominal) == pytest.approx(question.multiple * SMALL)


def test_sizes_turn_to_the_side_that_is_possible():
    question = next(q for q in QUESTIONS if q.asked == (("spin_decay", "c"),))

    assert question.posed(small).hidden[0].value > 0


def test_balls_never_leave_the_table_as_fast_as_they_met_it():
    asked = [q for q in QUESTIONS if q.asked == (("speed_dependent_restitution", "c"),)]

    assert asked and all(question.posed(small).hidden[0].value > 0 for question in asked)


def test_what_is_not_possible_is_not_posed():
    for question in (group("sweep")[0], group("pair")[0]):
        assert question.posed(lambda _, names: [np.inf] * len(names)) is None
        assert question.posed(lambda _, names: [np.nan] * len(names)) is None


def test_pairs_are_of_different_families():
    for question in group("pair") + group("nominal_off"):
        first, second = question.asked
        assert family(first) != family(second)
        assert len(question.posed(small).hidden) == 2


def test_parameters_that_are_off_come_with_a_missing_effect():
    for question in group("nominal_off"):
        kinds = {cause.kind for cause in question.posed(small).hidden}
        assert kinds == {"wrong_value", "missing_effect"}


def test_groups_are_what_their_names_say():
    assert all(not q.asked and not q.posed(small).causes for q in group("clean"))
    assert all(q.trial.withheld == (q.asked[0][0],) for q in group("withheld"))
    assert all(q.trial.spin_labels == "none" for q in group("unlabelled"))
    assert all(q.trial.directions == 1 for q in group("one_direction"))
    sensor = {catalogue()[q.asked[0][0]].acts for q in group("sensor_fault")}
    assert sensor == {"sensor"}


def test_a_reduced_exam_is_spread_over_the_groups():
    few = spread(QUESTIONS, 24)

    assert len(few) == 24
    assert {"sweep", "clean"} < {question.group for question in few}
