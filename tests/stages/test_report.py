"""The report stage, from the files of the stages before it."""

import re
from pathlib import Path

import pytest

from rallygap.pipeline.params import ReportSettings, load_params, read_yaml
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_page import GAP_STAGES
from rallygap.stages.report import report
from tests.pipeline.web.example_reports import make_reports

# Of those that dvc.yaml lists, all but the report itself, which comes last.
REPOSITORY = Path(__file__).parents[2]
STAGES = list(read_yaml(REPOSITORY / "dvc.yaml")["stages"])[:-1]
PARAMS = load_params(REPOSITORY / "params.yaml")


def run_report(root, shots=2, returns=2):
    settings = ReportSettings(shots=shots, returns=returns)
    report(StageRun("report", root, PARAMS.model_copy(update={"report": settings})))
    return root / "reports" / "index.html"


def test_the_page_shows_results_the_gap_the_paper_and_the_other_stages(tmp_path):
    make_reports(tmp_path)

    page = run_report(tmp_path).read_text()

    shown = re.findall(r'<section id="(\w+)"', page)
    gap = [one for one in STAGES if one in GAP_STAGES]
    rest = [one for one in STAGES if one not in GAP_STAGES]
    assert shown == ["results", *gap, "paper", "returns", "shots", *rest]


def test_running_twice_writes_the_same_bytes(tmp_path):
    make_reports(tmp_path)

    first = run_report(tmp_path).read_bytes()
    assert run_report(tmp_path).read_bytes() == first


@pytest.mark.parametrize(("shots", "returns"), [(1, 0), (0, 1), (2, 1)])
def test_as_many_shots_and_returns_are_shown_as_asked_for(tmp_path, shots, returns):
    make_reports(tmp_path)

    page = run_report(tmp_path, shots, returns).read_text()
    assert page.count("<option>") == shots + returns


@pytest.mark.parametrize("stage", STAGES)
def test_missing_stage_is_named_and_nothing_is_written(tmp_path, stage):
    make_reports(tmp_path)
    (tmp_path / "reports" / stage / "contents.json").unlink()

    with pytest.raises(InputError, match=f"run `dvc repro {stage}` first"):
        run_report(tmp_path)
    assert not (tmp_path / "reports" / "index.html").exists()
