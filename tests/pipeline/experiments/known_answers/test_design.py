"""Every question is asked once."""

import pytest

from rallygap.pipeline.experiments.known_answers.design import DISTORTION, Question, planted_errors


def test_errors_have_rising_sizes_in_minimum_detectable_effects():
    limits = {"drag.cd": 0.02, "gravity.g": 0.1}
    names = [Question("lab", 0, error).name for error in planted_errors(limits)]
    assert len(set(names)) == len(names) == 3 * 3
    sizes = {}
    for error in planted_errors(limits):
        sizes.setdefault((error.place, error.identity), []).append(error.value)
    assert sizes["simulator", "gravity.g"] == pytest.approx([0.2, 0.4, 0.8])
    assert all(values == sorted(set(values)) and len(values) == 3 for values in sizes.values())


def test_no_error_is_planted_that_the_shots_cannot_show_or_that_is_implausible():
    planted = [(one.identity, one.size) for one in planted_errors({"wind.x": 1.0})]
    assert [one for one in planted if one[0] != DISTORTION] == [("wind.x", "2x"), ("wind.x", "4x")]
