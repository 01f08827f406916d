"""An answer is right if the planting adds the planted error to the verdict, and nothing else."""

from collections import defaultdict

import pytest

from rallygap.pipeline.experiments.known_answers.design import DISTORTION, PlantedError, Question
from rallygap.pipeline.experiments.known_answers.scores import Answer, answer_table, set_scores
from tests.pipeline.experiments.known_answers.made_up import cause, found

REFERENCES = defaultdict(float, {"drag.cd": 0.54, "position_scale.s": 0.03})
DRAG = PlantedError("simulator", "drag.cd", "medium", 0.1)
SPOILED = 0.64
WIND = cause("wind.x", 0.5, 0.0)


def answer(causes, before=(), error=DRAG):
    return Answer(Question("lab", 0, error), found(*causes), found(*before), REFERENCES)


def test_the_planted_error_alone_is_leading_exact_and_covered():
    one = answer([cause("drag.cd", 0.545, SPOILED)])
    assert (one.leading, one.exact, one.covered, one.false) == (True, True, (True,), ())


def test_causes_of_the_unplanted_verdict_do_not_count():
    one = answer([WIND, cause("drag.cd", 0.545, SPOILED)], before=[WIND])
    assert (one.leading, one.exact) == (True, True)
    other_value = cause("wind.x", 0.55, 0.0)
    one = answer([other_value, cause("drag.cd", 0.545, SPOILED)], before=[WIND])
    assert (one.leading, one.exact, one.false) == (False, False, (other_value,))


def test_a_cause_behind_the_planted_error_is_false_but_leaves_it_leading():
    one = answer([cause("drag.cd", 0.545, SPOILED), WIND])
    assert (one.leading, one.exact, one.false) == (True, False, (WIND,))


def test_sensor_faults_are_not_false_leading_causes_and_minor_ones_are_no_causes():
    fault, minor = (cause("wind.x", 0.5, 0.0, role=role) for role in ("sensor", "minor"))
    one = answer([cause("drag.cd", 0.545, SPOILED), fault])
    assert (one.exact, one.false) == (False, ())
    assert answer([minor, cause("drag.cd", 0.545, SPOILED)]).exact
    assert not answer([cause("drag.cd", 0.545, SPOILED, role="minor")]).leading


def test_camera_distortion_is_no_new_cause_because_all_recordings_have_one():
    distorted = cause("camera_distortion.amplitude", 0.004, 0.0, role="sensor")
    one = answer([distorted, cause("drag.cd", 0.545, SPOILED)])
    assert (one.leading, one.exact, one.false) == (True, True, ())


def test_a_verdict_that_ignores_what_was_planted_is_wrong():
    before = [cause("position_scale.s", 0.03, 0.0)]
    error = PlantedError("recordings", "position_scale.s", "medium", 0.04)
    assert not answer(before, before, error).leading
    grown = answer([cause("position_scale.s", 1.03 * 1.04 - 1, 0.0)], before, error)
    assert (grown.exact, grown.covered) == (True, (True,))


def test_the_reference_value_is_the_truth_also_where_the_unplanted_verdict_has_another():
    before = [cause("drag.cd", 0.5, 0.52)]
    one = answer([cause("drag.cd", 0.545, SPOILED)], before)
    assert (one.exact, one.covered) == (True, (True,))
    assert answer([cause("drag.cd", 0.5, SPOILED)], before).covered == (False,)


def test_an_inseparable_cause_counts_as_the_planted_one_but_has_no_interval_for_it():
    tilt = PlantedError("simulator", "frame_tilt.x", "medium", 0.02)
    one = answer([cause("wind.x", 0.5, 0.0, possible=("frame_tilt.y",))], error=tilt)
    assert (one.leading, one.by_name, one.exact, one.covered) == (True, False, True, ())
    assert answer([cause("frame_tilt.y", 0.02, 0.0)], error=tilt).by_name
    assert not answer([WIND], error=tilt).leading


def test_no_cause_at_all_misses_the_planted_error():
    one = answer([])
    assert (one.leading, one.exact, one.covered, one.false) == (False, False, (), ())


ANSWERS = [
    answer([WIND], error=None),
    answer([cause("wind.x", 0.5, 0.0, role="sensor")], error=None),
    answer([cause("drag.cd", 0.545, SPOILED)]),
    answer([cause("drag.cd", 0.6, SPOILED), WIND]),
    answer([]),
    answer([], error=PlantedError("recordings", DISTORTION, "small", 0.002)),
    answer([WIND], error=PlantedError("recordings", DISTORTION, "large", 0.008)),
]


def test_the_scores_of_a_set_count_its_questions():
    assert set_scores(ANSWERS) == {
        "questions": 3,
        "leading": 2,
        "by_name": 2,
        "exact": 1,
        "false_causes": 1,
        "intervals": 2,
        "covered": 1,
        "coverage": 0.5,
        "distorted": 2,
        "distorted_clean": 1,
        "unplanted": 2,
        "unplanted_clean": 1,
    }
    assert set_scores([answer([])])["coverage"] is None


def test_the_table_has_a_row_a_question():
    table = answer_table(ANSWERS)
    assert table["planted"].tolist() == ["none"] * 2 + ["drag.cd"] * 3 + [DISTORTION] * 2
    assert table["causes"][3] == "drag.cd 0.6 (0.59 to 0.61); wind.x 0.5 (0.49 to 0.51)"
    assert table["leading"].dropna().tolist() == [True, True, False]
    assert table["covered"].dropna().tolist() == [True, False]
    assert table["true"][2] == "drag.cd 0.54"
    assert table["false"].dropna().tolist() == ["", "wind.x", "", "", "wind.x"]
    assert table["before_mm"][0] == pytest.approx((9 + 21 + 40) / 3)
