"""Tables of results in pages: their query language, and that the pages have what queries give."""

import json
import re
from itertools import chain, product
from pathlib import Path

import pytest

from experiments.clone import run
from rallygap.pipeline.documentation.__main__ import PAGES, written_pages
from rallygap.pipeline.documentation.tables import pages, with_tables
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError

ROOT = Path(__file__).parents[3]
ERRORS = """predictor,horizon_ms,mean,low,high
physics_c,100,19.3,17,21
physics_c,300,76.1,64,89
oracle,100,12.2,12,12
oracle,300,,,
"""
SPREAD = """<!-- table: stage/errors.csv
columns:
  predictor: "{predictor}"
  "{horizon_ms} ms": "{mean:.0f} ({low:.0f} to {high:.0f})"
-->
<!-- end -->
"""


@pytest.fixture
def shown(tmp_path):
    """The lines of the table that a block of a page becomes, without those of the head."""
    reports = tmp_path / "reports" / "stage"
    reports.mkdir(parents=True)
    (reports / "errors.csv").write_text(ERRORS)
    (reports / "rates.csv").write_text("rate,ours,other\nright,3,1\nasked,4,4\n")
    scenes = {"mujoco": {"drag": {"causes": ["drag.cd", "wind.x"], "right": True}}}
    (reports / "scenes.json").write_text(json.dumps({"machine": "a", "engines": scenes}))

    def lines(block):
        page = tmp_path / "page.md"
        page.write_text(f"Before.\n\n{block}\nAfter.\n")
        text = with_tables(page, tmp_path)
        page.write_text(text)
        assert with_tables(page, tmp_path) == text, "writing a table again changes it"
        assert text.startswith("Before.\n") and text.endswith("After.\n")
        return [line for line in text.splitlines() if line.startswith("| ")]

    return lines


def test_a_head_with_a_field_spreads_its_column(shown):
    assert shown(SPREAD) == [
        "| predictor | 100 ms | 300 ms |",
        "| --- | --- | --- |",
        "| physics, simulator C | 19 (17 to 21) | 76 (64 to 89) |",
        "| oracle | 12 (12 to 12) | – |",
    ]


def test_rows_are_chosen_and_columns_computed(shown):
    query = """<!-- table: stage/errors.csv
rows: horizon_ms == 100
let: {width: high - low}
columns: {predictor: "{predictor}", "width (um)": "{1000 * width:,.0f}"}
-->
<!-- end -->"""
    assert shown(query)[2:] == ["| physics, simulator C | 4,000 |", "| oracle | 0 |"]


def test_groups_become_rows(shown):
    query = """<!-- table: stage/errors.csv
by: [horizon_ms]
take: {least: [mean, min], known: [mean, count], of: [mean, size]}
columns: {ms: "{horizon_ms}", least: "{least:.1f}", known: "{known} of {of}"}
-->
<!-- end -->"""
    assert shown(query)[2:] == ["| 100 | 12.2 | 2 of 2 |", "| 300 | 76.1 | 1 of 2 |"]


def test_nested_json_has_a_column_for_each_level(shown):
    query = """<!-- table: stage/scenes.json
within: engines
levels: [engine, scene]
columns: {scene: "{engine}, {scene}", causes: "{causes}", right: "{right}"}
-->
<!-- end -->"""
    assert shown(query)[2:] == ["| mujoco, drag | drag.cd, wind.x | yes |"]


def test_a_table_may_have_a_column_for_each_row_to_show(shown):
    query = """<!-- table: stage/rates.csv
transpose: true
columns: {method: "{name}", right: "{right:.0f} of {asked:.0f}"}
-->
<!-- end -->"""
    assert shown(query)[2:] == ["| ours | 3 of 4 |", "| other | 1 of 4 |"]


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (SPREAD.replace("errors.csv", "other.csv"), "No such file"),
        (SPREAD.replace("{mean:", "{median:"), "median"),
        (SPREAD.replace("columns", "colums"), "colums"),
        (SPREAD.replace("<!-- end -->", ""), "without <!-- end -->"),
    ],
)
def test_a_broken_block_is_refused_by_the_name_of_its_page(shown, broken, problem):
    with pytest.raises(InputError, match=problem) as refused:
        shown(broken)
    assert "page.md" in str(refused.value)


def test_pages_have_what_queries_and_code_give():
    written = written_pages(ROOT)
    stale = [path.name for path, text in written.items() if path.read_text("utf-8") != text]
    assert stale == [], "run `python -m rallygap.pipeline.documentation`"


@pytest.fixture(scope="module")
def shown_results():
    """Files under reports/ whose tables and figures pages show; docs/images/ has copies."""
    shown = set()
    for page in pages(ROOT):
        text = page.read_text("utf-8")
        shown |= {f"reports/{table}" for table in re.findall(r"<!-- table: (\S+)", text)}
        for link in re.findall(r"!\[[^]]*\]\((?!https?:)([^)]+)\)", text):
            image = (page.parent / link).resolve().relative_to(ROOT)
            if image.parts[0] == "reports":
                shown.add(image.as_posix())
            elif len(image.parts) == 4:
                shown.add(f"reports/{image.parts[2]}/figures/{image.name}")
    return shown


def test_every_result_that_a_page_shows_is_in_git(shown_results):
    tracked = set(run(ROOT, "git", "ls-files").split())
    for shown in shown_results:
        copy = f"docs/images/{Path(shown).parts[1]}/{Path(shown).name}"
        assert {shown, copy} & tracked, shown


def outputs(pipeline):
    """The files and folders that the stages of a pipeline write, those of a matrix one by one."""
    for stage in read_yaml(pipeline)["stages"].values():
        listed = chain(*(stage.get(kind, []) for kind in ("outs", "metrics", "plots")))
        paths = [one if isinstance(one, str) else next(iter(one)) for one in listed]
        matrix = stage.get("matrix", {})
        for values in product(*matrix.values()):
            for path in paths:
                for key, value in zip(matrix, values, strict=True):
                    path = path.replace(f"${{item.{key}}}", value)
                yield path


def test_every_result_that_a_page_shows_is_an_output_of_a_stage(shown_results):
    made = {*outputs(ROOT / "dvc.yaml"), *outputs(ROOT / "experiments" / "dvc.yaml")}
    assert "reports/shots" in made
    assert [
        shown
        for shown in shown_results
        if not made & {shown, *(folder.as_posix() for folder in Path(shown).parents)}
    ] == []


def test_every_link_and_picture_leads_somewhere():
    for page in pages(ROOT):
        for link in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text("utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"
    assert all((ROOT / name).exists() for name in PAGES)


def test_the_readme_is_for_the_first_five_minutes():
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 150
