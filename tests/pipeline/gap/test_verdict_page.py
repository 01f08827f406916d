"""The page of a verdict: complete, escaped, offline."""

import html
import re

import pytest

from pipeline.gap.diagnose_folder import figures_of
from pipeline.gap.verdict_page import render_gap_page
from pipeline.runtime.errors import InputError
from tests.pipeline.verdicts import GRAVITY, WIND, findings, verdict
from tests.pipeline.web.test_page_in_browser import DESKTOP, PHONE, open_page, requests
from tests.pipeline.web.test_report_page import HOSTILE, Tags

BOTH = verdict("ambiguous", (WIND, GRAVITY))


@pytest.fixture
def rendered(tmp_path):
    """A function from findings to their page."""

    def render(found, amended="gravity: {g: 9.81}\n"):
        figures = figures_of(found.verdict)
        for one in figures:
            one.figure.savefig(tmp_path / f"{one.name}.png")
        return render_gap_page(found, amended, tmp_path, figures)

    return render


def sections(page):
    return [tag["id"] for tag in Tags(page).named("section")]


def test_the_sentences_come_first(rendered):
    found = findings(BOTH)
    page = html.unescape(rendered(found))
    assert "<h1>Verdict: ambiguous</h1>" in page
    places = [page.index(sentence) for sentence in (*found.sentences, "<main>")]
    assert places == sorted(places)


def test_causes_have_a_row_with_class_and_experiment(rendered):
    page = rendered(findings(BOTH))
    cells = ["gravity.g", "wrong value", "9.81", "10.3 m/s^2", "10.2 to 10.4", "0.0002"]
    cells += ["30 %", "buoyancy.b", "record shots in both directions"]
    row = next(row for row in page.split("<tr>") if row.startswith("<td>gravity.g</td>"))
    assert re.findall(r"<td[^>]*>([^<]*)</td>", row) == cells


def test_where_it_arises_has_figures_and_all_covariates(rendered):
    page = rendered(findings(BOTH))
    section = page[page.index('<section id="where"') : page.index('<section id="errors"')]
    assert section.count("<img ") == 2
    row = '<td>speed at launch</td><td class="number">3</td><td class="number">40 %</td>'
    assert row in section


def test_errors_are_listed_over_the_horizon_and_at_landing(rendered):
    page = rendered(findings(BOTH))
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in page.split("<tr>")]
    assert ["position, 200 ms ahead", "21.0 mm", "8.0 mm", "7.0 mm"] in rows
    assert ["landing position", "31.0 mm", "14.0 mm", "12.0 mm"] in rows
    assert ["landing time", "4.00 ms", "1.90 ms", "1.50 ms"] in rows
    assert "reduced by 11.0 to 24.0 mm and 1.20 to 3.10 ms" in page


def test_detection_limits_limitations_data_and_settings_are_listed(rendered):
    page = rendered(findings())
    assert re.search(r"<td>wind.x</td><td>[^<]+</td><td class=\"number\">0.04</td>", page)
    assert "<li>all shots go in one direction</li>" in page
    assert "<dt>rows and labels rejected</dt><dd>2 not a number</dd>" in page
    assert "<pre>gravity: {g: 9.81}" in page


def test_sections_without_content_are_left_out(rendered):
    every = ["causes", "where", "errors", "detection", "amended", "data"]
    assert sections(rendered(findings(BOTH))) == every
    assert sections(rendered(findings(verdict("no_gap", (), gap=None)))) == every[3:]


def test_names_from_the_data_cannot_become_markup(rendered):
    tags = [tag for tag, _ in Tags(rendered(findings())).found]
    hostile = rendered(findings(simulator_name=HOSTILE, name=HOSTILE), amended=HOSTILE)
    assert [tag for tag, _ in Tags(hostile).found] == tags


def test_links_lead_to_sections_and_nothing_outside(rendered):
    tags = Tags(rendered(findings(BOTH)))
    ids = [attributes["id"] for _, attributes in tags.found if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert [link["href"][1:] for link in tags.named("a")] == sections(rendered(findings(BOTH)))
    assert all(image["src"].startswith("data:") for image in tags.named("img"))


def test_a_missing_figure_is_named(tmp_path):
    with pytest.raises(InputError, match=r"causes\.png"):
        render_gap_page(findings(), "", tmp_path, figures_of(verdict()))


@pytest.mark.browser
@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_page_is_quiet_and_fits_the_window(browser, rendered, tmp_path, size):
    path = tmp_path / "report.html"
    path.write_text(rendered(findings(BOTH)), encoding="utf-8")
    open_page(browser, path, size)
    assert browser.get_log("browser") == []
    assert requests(browser) == [path.as_uri()]
    assert browser.execute_script("return document.documentElement.scrollWidth") <= size[0]
