"""What the page draws of the paper."""

import pytest

from pipeline.beside_paper.catalogue import GROUPS
from pipeline.beside_paper.entries import Entry, Finding, Group
from pipeline.beside_paper.reports import Reports
from pipeline.beside_paper.verdicts import LEVEL, Interval
from pipeline.figures.paper_section import mark, paper_section

ENTRY = Entry("key", "what", 50.0, "%", "sim2real", "file", lambda _: Finding(LEVEL))


def group(axis):
    return Group("key", "title", "about", axis, (ENTRY,))


def test_values_lie_on_their_axis_and_do_not_leave_it():
    found = Finding(LEVEL, 0.0, Interval(0.0, -40.0, 150.0))
    drawn = mark(group((-100.0, 100.0)), ENTRY, found)
    assert (drawn.zero, drawn.paper, drawn.ours) == (50.0, 75.0, 50.0)
    assert (drawn.low, drawn.high) == (30.0, 100.0)


@pytest.mark.parametrize(("ours", "place"), [(50.0, 50.0), (5.0, 25.0), (5e-9, 0.0), (5e5, 100.0)])
def test_sizes_are_drawn_by_their_ratio(ours, place):
    drawn = mark(group(None), ENTRY, Finding(LEVEL, ours))
    assert (drawn.paper, drawn.ours) == (50.0, place)


def test_what_is_no_number_is_not_drawn():
    assert mark(group(None), ENTRY, Finding(LEVEL, "half a cosine")).ours is None
    assert mark(group((0.0, 1.0)), ENTRY, Finding(LEVEL)).ours is None


def test_every_entry_is_shown_with_the_run_that_it_is_from(tmp_path):
    shown = paper_section(Reports(tmp_path, {}), {"sim2real": "3fa9c1d20b77"})
    assert [len(one["rows"]) for one in shown["groups"]] == [len(one.entries) for one in GROUPS]
    runs = {run["stage"]: run["fingerprint"] for one in shown["groups"] for run in one["runs"]}
    assert runs["sim2real"] == "3fa9c1d20b77" and runs["sim2sim"] == ""
