"""Methods see recordings only, and the truth is recorded after they have answered."""

from dataclasses import replace

import pytest

from experiments.exam.design.question import Question
from experiments.exam.interface import Answer
from experiments.exam.runner import RemovableGap, run_question
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Variation
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_records import named
from tests.experiments.exam.example_trials import NOMINAL, trial

WIND, DRAG = Hypothesis("wind", "x"), Hypothesis("drag", "cd")


def question(*hidden, group="sweep", **settings):
    return Question(group, trial(shots=12, seed=1002, **settings), hidden, cell="base")


def no_gap(recordings, nominal, withheld):
    return Answer("no_gap", (), nominal)


def test_a_method_sees_no_truth_and_the_record_has_it():
    calls = []

    def spy(*arguments):
        calls.append(arguments)
        return no_gap(*arguments)

    asked = question(WIND, dynamics="independent", withheld=("friction",))
    record, again = (run_question(asked, {"spy": spy}) for _ in range(2))
    recordings, *others = calls[0]
    assert others == [NOMINAL, ("friction",)]
    known = {"times", "positions", "label_times", "labels"}
    assert all(vars(recording).keys() == known for recording in recordings)
    (truth,) = record.hidden
    assert (truth.identity, truth.kind, truth.nominal) == ("wind.x", "missing_effect", 0.0)
    assert abs(truth.value) > 0.0
    assert record.parameters == ("wind.x",)
    assert record.answers["spy"].gap_after_mm == record.gap_before_mm > 0.0
    assert record.seconds.keys() == {"spy"}
    assert again == record.model_copy(update={"seconds": again.seconds})


def test_a_method_that_fails_has_no_answer_and_the_others_go_on():
    def broken(recordings, nominal, withheld):
        raise ZeroDivisionError("too few")

    def wild(recordings, nominal, withheld):
        return Answer("named", (named(estimate=float("nan")),), nominal)

    methods = {"broken": broken, "wild": wild, "no_gap": no_gap}
    record = run_question(question(group="clean"), methods)
    assert record.answers["broken"].conclusion is record.answers["wild"].conclusion is None
    assert record.answers["broken"].error == "ZeroDivisionError: too few"
    assert "finite number" in record.answers["wild"].error
    assert record.answers["no_gap"].conclusion == "no_gap"
    assert (record.hidden, record.gap_before_mm) == ((), None)


@pytest.mark.parametrize("labels", ["none", "per_shot"])
def test_a_question_that_cannot_be_posed_has_a_reason_and_no_answers(labels):
    flipped = question(Hypothesis("spin_sign_flip", "share"), spin_labels=labels)

    record = run_question(flipped, {"no_gap": no_gap})
    assert (record.not_posed is not None) == (labels == "none")
    assert (record.answers == {}) == (record.seconds == {}) == (labels == "none")


def test_the_effects_of_several_causes_are_measured():
    record, single = (
        run_question(question(*hidden, group="several"), {"no_gap": no_gap})
        for hidden in ((WIND, DRAG), (WIND,))
    )

    assert all(cause.effect_mm > 0.0 for cause in record.hidden)
    assert sum(cause.effect_mm for cause in record.hidden) > 0.5 * record.gap_before_mm
    assert single.hidden[0].effect_mm is None


def test_where_the_nominal_simulator_is_far_off_this_is_part_of_the_truth():
    asked = question(WIND, far_off={"drag": {"cd": 0.54}})
    far = replace(asked.trial, nominal=NOMINAL.amended("drag", cd=0.3))
    record = run_question(replace(asked, trial=far), {"no_gap": no_gap})

    assert record.parameters == ("wind.x", "drag.cd")
    wind, drag = record.hidden
    assert (drag.nominal, drag.value, drag.kind) == (0.3, 0.54, "wrong_value")
    assert drag.effect_mm > wind.effect_mm
    assert record.answers["no_gap"].gap_after_mm == record.gap_before_mm


def test_a_cause_that_varies_has_no_removable_gap():
    drift = question(WIND, group="drift", variation=Variation("drift", WIND))
    record = run_question(drift, {"no_gap": no_gap})
    assert record.hidden[0].identity == "wind.x"
    assert (record.gap_before_mm, record.answers["no_gap"].gap_after_mm) == (None, None)


def gap(**settings):
    _, truth = simulate_trial(trial(shots=5, **settings))
    return RemovableGap(truth), truth.trial.simulator


def test_the_removable_gap_is_proportional_to_how_wrong_a_simulator_is():
    found, true = gap(causes={"wind": {"x": 0.4}, "clock_rate": {"d": 0.004}})
    assert found.remaining(true) == pytest.approx(0.0, abs=1e-6)  # scatter and noise aside
    assert found.remaining(NOMINAL) > 3.0
    found, _ = gap(causes={"wind": {"x": 0.4}})
    half = found.remaining(NOMINAL.amended("wind", x=0.2))
    assert half == pytest.approx(found.remaining(NOMINAL) / 2, rel=0.05)
    # The best size of another form leaves little.
    found, equivalent = gap(causes={"wind": {"x": 0.4}}, dynamics="independent")
    assert 0.0 < found.remaining(equivalent) < 0.3 * found.remaining(NOMINAL)
