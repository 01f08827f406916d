"""The page of a verdict: complete, escaped, offline."""

import re
from functools import cache

import pytest

from rallygap.pipeline.gap.diagnose_folder import figures_of
from rallygap.pipeline.gap.verdict_page import render_gap_page
from tests.pipeline.report.test_page_in_browser import DESKTOP, PHONE, open_page, requests
from tests.pipeline.report.test_report_page import HOSTILE, Tags
from tests.pipeline.verdicts import CAMERA, CAMERA_NODES, GRAVITY, MINOR, WIND, findings, verdict

FOUND = {
    "plain": findings(),
    "two causes": findings(verdict("ambiguous", (WIND, GRAVITY))),
    "all": findings(verdict("ambiguous", (WIND, GRAVITY, CAMERA, MINOR), camera=CAMERA_NODES)),
    "hostile": findings(simulator_name=HOSTILE, name=HOSTILE),
    "nothing": findings(verdict("no_gap", (), gap=None, checks=())),
}
# Of every table's box: what it hides in width and in height.
HIDDEN = """
return [...document.querySelectorAll(".table")].map(
  (box) => [box.scrollWidth - box.clientWidth, box.scrollHeight - box.clientHeight]);
"""


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """A function from the name of findings to their page."""
    folder = tmp_path_factory.mktemp("figures")

    @cache
    def render(name):
        figures = figures_of(FOUND[name])
        for one in figures:
            one.figure.savefig(folder / f"{one.name}.png")
        amended = HOSTILE if name == "hostile" else "gravity: {g: 9.81}\n"
        return render_gap_page(FOUND[name], amended, folder, figures)

    return render


def cells(page, first):
    """The cells of the row that starts with a cell; names may break after an underscore."""
    rows = page.replace("<wbr>", "").split("<tr>")
    row = next(row for row in rows if row.startswith(f"<td>{first}</td>"))
    return re.findall(r"<td[^>]*>([^<]*)</td>", row)


def test_causes_have_a_row_with_role_worth_and_class(rendered):
    page, fewer = rendered("all"), rendered("two causes")
    expected = ["gravity.g", "leading cause", "wrong value", "9.81", "10.3 m/s^2", "10.2 to 10.4"]
    expected += ["-0.4 (-1.1 to 0.2)", "30 %", "0.0002", "buoyancy.b"]
    assert cells(page, "gravity.g") == expected
    assert cells(page, CAMERA.identity)[1] == "sensor fault"
    expected = ["spin_decay.c", "0", "0.003 1/m", "0.001 to 0.005", "–", "4 %"]
    assert cells(page, "spin_decay.c") == expected
    for part in ('id="minor-table"', 'id="camera-figure"'):
        assert part in page and part not in fewer


def test_checks_errors_covariates_and_facts_are_listed(rendered):
    page = rendered("plain")
    for row in (
        ["prediction errors", "1.05", "0.9 to 1.2", "0.75 to 1.33", "yes"],
        ["position, 200 ms ahead", "21.0 mm", "8.0 mm", "7.0 mm"],
        ["landing position", "31.0 mm", "14.0 mm", "12.0 mm"],
        ["landing time", "4.00 ms", "1.90 ms", "1.50 ms"],
        ["speed at launch", "3", "40 %", "0.0002"],
    ):
        assert cells(page, row[0]) == row
    assert cells(page, "table_bounce.friction")[2] == "0.012"
    assert "reduced by 11.0 to 24.0 mm and 1.20 to 3.10 ms" in page
    assert "<dt>rows and labels rejected</dt><dd>2 not a number</dd>" in page


def test_names_from_the_data_cannot_become_markup(rendered):
    plain, hostile = (
        [tag for tag, _ in Tags(rendered(name)).found] for name in ("plain", "hostile")
    )
    assert plain == hostile


def test_links_lead_to_sections_and_nothing_outside(rendered):
    tags = Tags(rendered("two causes"))
    ids = [attributes["id"] for _, attributes in tags.found if "id" in attributes]
    assert len(ids) == len(set(ids))
    sections = [section["id"] for section in tags.named("section")]
    assert sections == ["checks", "errors", "causes", "where", "detection", "amended", "data"]
    assert [link["href"] for link in tags.named("a")] == [f"#{name}" for name in sections]
    assert all(image["src"].startswith("data:") for image in tags.named("img"))
    # Those without content are left out.
    few = [section["id"] for section in Tags(rendered("nothing")).named("section")]
    assert few == sections[4:]


@pytest.mark.browser
@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_page_is_quiet_and_fits_the_window_with_tables_shown_whole(
    browser, rendered, tmp_path, size
):
    path = tmp_path / "report.html"
    path.write_text(rendered("all"), encoding="utf-8")
    open_page(browser, path, size)
    assert browser.get_log("browser") == []
    assert requests(browser) == [path.as_uri()]
    assert browser.execute_script("return document.documentElement.scrollWidth") <= size[0]
    if size == DESKTOP:
        assert browser.execute_script(HIDDEN) == [[0, 0]] * 6
