"""The page's section on the paper."""

import pytest

from rallygap.pipeline.paper.assessments import NOT_DIFFERENT, Finding, Interval
from rallygap.pipeline.paper.comparison import Group, groups
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.values import Value
from rallygap.pipeline.report.paper import mark, paper_section

VALUE = Value("group", "id", "what", rule="more", value=50.0, ours="file")


def test_values_are_drawn_inside_their_axis():
    found = Finding(NOT_DIFFERENT, 0.0, Interval(0.0, -40.0, 150.0))
    drawn = mark(Group("id", "title", axis=(-100.0, 100.0)), VALUE, found)
    assert (drawn.zero, drawn.paper, drawn.ours) == (50.0, 75.0, 50.0)
    assert (drawn.low, drawn.high) == (30.0, 100.0)


@pytest.mark.parametrize(
    ("ours", "place"),
    [(50.0, 50.0), (5.0, 25.0), (5e-9, 0.0), (5e5, 100.0), ("half a cosine", None)],
)
def test_sizes_are_drawn_by_their_ratio(ours, place):
    assert mark(Group("id", "title"), VALUE, Finding(NOT_DIFFERENT, ours)).ours == place


def test_every_value_is_shown_and_files_on_the_page_are_linked(tmp_path):
    file = "shot_quality/quality.csv"
    shown = paper_section(Reports(tmp_path, {}), {file, "sim2real"})
    assert [len(one["rows"]) for one in shown["groups"]] == [len(one.values) for one in groups()]
    parts = {part: anchor for one in shown["exhibits"] for part, anchor in one["ours"] if anchor}
    assert parts == {file: file}
