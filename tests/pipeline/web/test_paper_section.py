"""What the page draws of the paper."""

from pathlib import Path

import pytest

from pipeline.io.report_manifest import Contents, read_contents
from pipeline.paper.catalogue import EXHIBITS, GROUPS
from pipeline.paper.entries import Entry, Finding, Group
from pipeline.paper.judgements import LEVEL, Interval
from pipeline.paper.run_reports import Reports, laptop_reports
from pipeline.web.paper_section import mark, paper_section
from stages.report import STAGES

ROOT = Path(__file__).parents[3]
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
    made = Contents(stage="sim2real", command="", fingerprint="3fa9c1d20b77", items=[])
    shown = paper_section(Reports(tmp_path, {}), [made])
    assert [len(one["rows"]) for one in shown["groups"]] == [len(one.entries) for one in GROUPS]
    runs = {run["stage"]: run["fingerprint"] for one in shown["groups"] for run in one["runs"]}
    assert runs["sim2real"] == "3fa9c1d20b77" and runs["sim2sim"] == ""


def test_the_files_of_every_figure_and_table_with_a_number_are_linked():
    contents = [read_contents(ROOT / "reports", stage) for stage in STAGES]
    shown = paper_section(laptop_reports(ROOT), contents)["exhibits"]
    linked = {one["name"]: [anchor for _, anchor in one["ours"] if anchor] for one in shown}
    for one in EXHIBITS:
        files = one.ours.rstrip("/").split(", ") if one.claims else []
        assert linked[one.name] == files


def test_what_the_page_does_not_have_is_not_linked(tmp_path):
    shown = paper_section(Reports(tmp_path, {}), [])["exhibits"]
    parts = [one["ours"] for one in shown]
    assert ["".join(text for text, _ in one) for one in parts] == [one.ours for one in EXHIBITS]
    assert not any(anchor for one in parts for _, anchor in one)
