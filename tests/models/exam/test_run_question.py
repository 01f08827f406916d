"""Sitting: a method sees recordings, and the truth is written down after it has answered."""

from dataclasses import fields, is_dataclass

import grimp
import pytest

from models.exam.answer import Finding, Found
from models.exam.design.questions import Cell, Question
from models.exam.design.trial import Recording
from models.exam.run_question import sit
from tests.models.exam.halls import NOMINAL, trial

SEALED = {"recordings", "session", "sizes", "removable", "sitting", "scoring", "sheet"}
FEW = {"shots": 12, "seed": 1002}


def question(*asked, group="sweep", **settings):
    return Question(group, trial(**FEW, **settings), asked, cell=Cell("base").name)


def nothing(recordings, nominal, withheld):
    return Finding("no_gap", (), nominal)


def test_a_method_is_given_recordings_the_nominal_simulator_and_what_is_withheld():
    seen = []

    def spy(*given):
        seen.append(given)
        return Finding("no_gap", (), NOMINAL)

    sit(question(("wind", "x"), withheld=("friction",)), {"spy": spy})
    ((recordings, nominal, withheld),) = seen
    assert (nominal, withheld) == (NOMINAL, ("friction",))
    assert {type(one) for one in recordings} == {Recording}
    assert is_dataclass(Recording)
    known = {"times", "positions", "label_times", "labels"}
    assert {field.name for field in fields(Recording)} == known


def test_methods_do_not_import_what_knows_the_truth():
    graph = grimp.build_graph("models")
    found = graph.find_upstream_modules("models.exam.methods.registry")

    assert not found & {f"models.exam.{name}" for name in SEALED}


def test_the_truth_is_on_the_sheet():
    sheet, seconds = sit(question(("wind", "x")), {"nothing": nothing})

    (truth,) = sheet.hidden
    assert (truth.name, truth.parameter, truth.nominal) == ("wind", "x", 0.0)
    assert abs(truth.value) > 0.0
    assert sheet.asked == ("wind.x",)
    assert sheet.answers["nothing"].after_mm == sheet.before_mm > 0.0
    assert seconds["nothing"] >= 0.0


def test_a_method_that_fails_has_no_answer_and_the_others_go_on():
    def broken(recordings, nominal, withheld):
        raise ZeroDivisionError("too few")

    sheet, _ = sit(question(group="clean"), {"broken": broken, "nothing": nothing})
    assert sheet.answers["broken"].answer is None
    assert sheet.answers["broken"].error == "ZeroDivisionError: too few"
    assert sheet.answers["nothing"].answer == "no_gap"
    assert sheet.hidden == ()
    assert sheet.before_mm is None


def test_what_is_no_number_is_no_answer():
    def wild(recordings, nominal, withheld):
        found = Found("wind", "wind", "x", float("nan"), None, ("wind",))
        return Finding("named", (found,), nominal)

    sheet, _ = sit(question(group="clean"), {"wild": wild})
    assert sheet.answers["wild"].answer is None
    assert "finite number" in sheet.answers["wild"].error


@pytest.mark.parametrize("labels", ["none", "per_shot"])
def test_a_question_that_cannot_be_posed_says_why(labels):
    backwards = question(("spin_sign_flip", "share"), spin_labels=labels)

    sheet, seconds = sit(backwards, {"nothing": nothing})
    assert (sheet.not_posed is not None) == (labels == "none")
    assert (sheet.answers == {}) == (seconds == {}) == (labels == "none")


def test_the_same_question_gives_the_same_sheet():
    asked = question(("wind", "x"), world="independent")

    assert sit(asked, {"nothing": nothing})[0] == sit(asked, {"nothing": nothing})[0]
