"""The design is complete, balanced and a pure function of its seed; names of groups are true."""

import hashlib
from collections import Counter
from itertools import product

import numpy as np
import pytest

from experiments.exam.design.parameters import NOT_OBSERVABLE, family, hideable
from experiments.exam.design.question import MULTIPLE
from experiments.exam.design.questions import exam
from experiments.exam.design.robustness import GROUPS, VARYING
from experiments.exam.simulate.recordings import simulate_trial
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NOMINAL

QUESTIONS = exam(NOMINAL, seed=0)
SMALL = 1e-5


def posed(question):
    return question.posed([SMALL] * len(question.hidden))


def changes(question):
    """Changes from nominal of a posed question, by parameter."""
    simulator = posed(question).simulator
    return {one: one.value(simulator) - one.value(NOMINAL) for one in question.hidden}


def group(name):
    """The questions of a group, of which there are some."""
    questions = [question for question in QUESTIONS if question.group == name]
    assert questions, name
    return questions


def test_it_has_the_sizes_of_a_full_exam_unique_trials_and_independent_dynamics():
    sizes = Counter(question.group for question in QUESTIONS)
    trials = [question.trial for question in QUESTIONS]

    assert 1050 <= sizes.pop("sweep") <= 1150
    assert sizes.pop("clean") == 500
    assert sum(sizes[name] for name in sizes if name not in GROUPS) == 300
    assert {sizes[name] for name in GROUPS} == {60}
    assert len({trial.name for trial in trials}) == len(trials)
    assert len({trial.seed for trial in trials}) == len(trials)
    for name in {question.group for question in QUESTIONS}:
        independent = [question.trial.dynamics == "independent" for question in group(name)]
        assert np.mean(independent) >= 0.25


def test_every_parameter_is_hidden_in_every_cell_unless_there_is_a_reason():
    hidden = Counter(question.hidden[0] for question in group("sweep"))

    assert set(hidden) == set(hideable())
    assert len(set(hidden.values())) == 1
    assert set(catalogue()) - {one.effect for one in hidden} == set(NOT_OBSERVABLE)


def digest(lines):
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def test_the_questions_before_the_robustness_groups_stay_as_they_are():
    """The committed records are of these questions."""
    known = [question for question in QUESTIONS if question.group not in GROUPS]
    described = [
        f"{q.group} {q.cell} {q.multiple} {q.hidden} {q.trial.name} {q.trial.seed} "
        f"{q.trial.dynamics} {q.trial.shots} {q.trial.directions} {q.trial.spin_labels} "
        f"{q.trial.cameras.position_noise} {q.trial.cameras.outliers} {q.trial.time_resolution} "
        f"{q.trial.withheld}"
        for q in known
    ]

    assert QUESTIONS[: len(known)] == known
    assert exam(NOMINAL, seed=1) != QUESTIONS
    assert digest(described) == "312e246411eb0058"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("sweep/magnus.cm/size-1x/1", "9083e4d7f50d9e34"),
        ("clean/12", "754c4755eb230d18"),
        ("sensor_fault/spin_axis_bias.x/22", "6dce6fae4dd34230"),
        ("withheld/side_force.cy/7", "fc524715d0113a73"),
    ],
)
def test_their_recordings_stay_as_they_are(name, expected):
    """To a micrometre; further digits differ between processors."""
    (question,) = [question for question in QUESTIONS if question.trial.name == name]
    recordings, _ = simulate_trial(posed(question))
    arrays = [
        array
        for one in recordings
        for array in (one.times, one.positions, one.label_times, one.labels)
    ]

    assert digest(str((array.round(6) + 0.0).tolist()) for array in arrays) == expected


def test_a_posed_question_hides_a_multiple_of_the_minimum_size_where_that_is_possible():
    for question in group("sweep")[::25]:
        (change,) = changes(question).values()
        assert abs(change) == pytest.approx(question.multiple * SMALL)
    increased = {Hypothesis("spin_decay", "c"), Hypothesis("speed_dependent_restitution", "c")}
    sweeps = [question for question in group("sweep") if question.hidden[0] in increased]
    assert sweeps and all(min(changes(question).values()) > 0 for question in sweeps)
    for question, size in product((group("sweep")[0], group("pair")[0]), (np.inf, np.nan)):
        assert question.posed([size] * len(question.hidden)) is None


def test_two_or_several_causes_are_of_different_families():
    for question in group("pair") + group("nominal_off"):
        first, second = question.hidden
        assert family(first) != family(second)
        assert all(changes(question).values())
    for question in group("nominal_off"):
        assert {one.listed(NOMINAL) for one in question.hidden} == {True, False}
    hidden = [question.hidden for question in group("several") if question.hidden]
    assert {len(some) for some in hidden} == {3, 4, 5, 6}
    assert all(len({family(one) for one in some}) == len(some) for some in hidden)
    assert min(question.multiple for question in group("several")) >= MULTIPLE


def test_groups_are_what_their_names_say():
    assert all(not q.hidden and not posed(q).causes for q in group("clean"))
    assert all(q.trial.withheld == (q.hidden[0].effect,) for q in group("withheld"))
    assert all(q.trial.spin_labels == "none" for q in group("unlabelled"))
    assert all(q.trial.directions == 1 for q in group("one_direction"))
    assert {catalogue()[q.hidden[0].effect].acts for q in group("sensor_fault")} == {"sensor"}


def errors(name):
    return [question.trial.errors for question in group(name)]


@pytest.mark.parametrize("name", GROUPS)
def test_a_fifth_of_every_robustness_group_is_clean_and_a_third_has_independent_dynamics(name):
    questions = group(name)
    clean = [question for question in questions if not question.differences]
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


def test_a_nominal_simulator_that_is_far_off_differs_in_a_parameter_and_an_effect():
    for question in group("far_off"):
        if question.hidden:
            missing, wrong = question.differences
            assert question.trial.base.effects.keys() == NOMINAL.effects.keys()
            assert wrong.value(question.trial.base) == wrong.value(NOMINAL)
            assert wrong.value(question.trial.nominal) != wrong.value(NOMINAL)
            assert not missing.listed(question.trial.nominal)
