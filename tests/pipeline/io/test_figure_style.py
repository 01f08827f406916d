"""Colours that stay with what they stand for."""

from rallygap.pipeline.web.figure_style import predictor_colour
from tests.pipeline.report.example_reports import OFFSETS


def test_the_projects_predictors_have_colours_of_their_own():
    names = [*OFFSETS, "transformer", "tae", "gru_tae", "oracle"]

    assert len({predictor_colour(name) for name in names}) == len(names)


def test_a_users_predictor_keeps_one_colour_that_no_known_one_has():
    known = {predictor_colour(name) for name in [*OFFSETS, "transformer", "oracle"]}

    assert predictor_colour("my_predictor") == predictor_colour("my_predictor")
    assert predictor_colour("my_predictor") not in known
