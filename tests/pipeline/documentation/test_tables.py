"""Tables of results in pages: their query language, and that the pages have what queries give."""

import json
import re
from itertools import product
from pathlib import Path

import pytest

from experiments.clone import run
from rallygap.pipeline.documentation.__main__ import PAGES, written_pages
from rallygap.pipeline.documentation.tables import pages, with_tables
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError
from tests.stage_files import outputs, paths

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


def test_queries_choose_compute_and_group_rows_and_read_nested_json(shown):
    grouped = """<!-- table: stage/errors.csv
rows: predictor != "other"
let: {width: high - low}
by: [horizon_ms]
take: {widest: [width, max], known: [mean, count], of: [mean, size]}
columns: {ms: "{horizon_ms}", "widest (um)": "{1000 * widest:,.0f}", known: "{known} of {of}"}
-->
<!-- end -->"""
    assert shown(grouped)[2:] == ["| 100 | 4,000 | 2 of 2 |", "| 300 | 25,000 | 1 of 2 |"]
    nested = """<!-- table: stage/scenes.json
within: engines
levels: [engine, scene]
columns: {scene: "{engine}, {scene}", causes: "{causes}", right: "{right}"}
-->
<!-- end -->"""
    assert shown(nested)[2:] == ["| mujoco, drag | drag.cd, wind.x | yes |"]


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


def shown_results():
    """Files under reports/ whose tables and figures pages show; docs/images/ has copies."""
    for page in pages(ROOT):
        text = page.read_text("utf-8")
        yield from (f"reports/{table}" for table in re.findall(r"<!-- table: (\S+)", text))
        for link in re.findall(r"!\[[^]]*\]\((?!https?:)([^)]+)\)", text):
            image = (page.parent / link).resolve().relative_to(ROOT)
            if image.parts[0] == "reports":
                yield image.as_posix()
            elif not image.name.startswith("mlflow_"):  # screenshots
                yield f"reports/{image.parts[2]}/figures/{image.name}"


def written(pipeline):
    """The files and folders that the stages of a pipeline write, those of a matrix one by one."""
    for stage in read_yaml(pipeline)["stages"].values():
        matrix = stage.get("matrix", {})
        for values in product(*matrix.values()):
            for path in paths(outputs(stage)):
                for key, value in zip(matrix, values, strict=True):
                    path = path.replace(f"${{item.{key}}}", value)
                yield path


def test_every_result_that_a_page_shows_is_in_git_and_an_output_of_a_stage():
    tracked = set(run(ROOT, "git", "ls-files").split())
    made = {*written(ROOT / "dvc.yaml"), *written(ROOT / "experiments" / "dvc.yaml")}
    assert {"reports/shots", "docs/paper.md"} <= made
    for shown in map(Path, shown_results()):
        copy = f"docs/images/{shown.parts[1]}/{shown.name}"
        assert {shown.as_posix(), copy} & tracked, shown
        assert {one.as_posix() for one in (shown, *shown.parents)} & made, shown


def test_every_link_and_picture_leads_somewhere():
    for page in pages(ROOT):
        for link in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text("utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"
    assert all((ROOT / name).exists() for name in PAGES)
