"""The PDF: every figure and table on its pages, and the same bytes every time."""

import re

import pytest

from pipeline.io.report_manifest import read_contents
from pipeline.paper.comparison import groups
from pipeline.paper.run_reports import Reports
from pipeline.runtime.errors import InputError
from pipeline.web.pdf import write_pdf
from tests.pipeline.web.example_reports import make_reports

STAGES = ("ingest", "segment", "evaluate_predictor")


def written(root, name="report.pdf"):
    contents = [read_contents(root / "reports", stage) for stage in STAGES]
    write_pdf(root / name, Reports(root / "reports", {}), contents)
    return (root / name).read_bytes()


@pytest.fixture(scope="module")
def pdf(root):
    return written(root)


def pages(pdf):
    return len(re.findall(rb"/Type /Page\b", pdf))


def test_the_same_reports_give_the_same_bytes(root, pdf):
    assert written(root, "again.pdf") == pdf


def test_it_holds_neither_the_day_nor_the_program(pdf):
    assert re.findall(rb"/CreationDate \((.*?)\)", pdf) == [b"D:20000101000000Z"]
    assert b"/Producer" not in pdf and b"/ModDate" not in pdf


def test_figures_are_there_whole(pdf):
    """Every pixel of theirs: the made-up figure is 1280 wide, its animation 60."""
    widths = set(map(int, re.findall(rb"/Width (\d+)", pdf)))
    assert widths == {1280, 60}


def test_there_is_a_page_for_every_group_figure_and_table(pdf):
    assert pages(pdf) >= 1 + len(groups()) + 4


def test_a_long_table_goes_on_over_pages(tmp_path, pdf):
    make_reports(tmp_path)
    table = tmp_path / "reports" / "segment" / "contacts.csv"
    rows = "".join(f"recording {number},{number}\n" for number in range(500))
    table.write_text(f"recording,speed_change\n{rows}")
    assert pages(pdf) + 4 <= pages(written(tmp_path)) <= pages(pdf) + 10


def test_missing_figure_is_named(tmp_path):
    make_reports(tmp_path)
    (tmp_path / "reports" / "evaluate_predictor" / "figures" / "spindoe.png").unlink()
    with pytest.raises(InputError, match=r"spindoe.png: cannot be read; run its stage again"):
        written(tmp_path)
