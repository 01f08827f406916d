"""The report stage, from the files of the stages before it."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from pipeline.errors import InputError
from pipeline.params import read_yaml
from pipeline.run import StageRun
from stages.report import report
from tests.pipeline.figures.made_up import make_reports

# Of those that dvc.yaml lists, all but the report itself, which comes last.
STAGES = list(read_yaml(Path(__file__).parents[2] / "dvc.yaml")["stages"])[:-1]


def run_report(root, shots=2):
    params = SimpleNamespace(report=SimpleNamespace(shots=shots))
    report(StageRun("report", root, params))
    return root / "reports" / "index.html"


def test_page_shows_the_stages_in_the_order_they_run(tmp_path):
    make_reports(tmp_path)

    page = run_report(tmp_path).read_text()

    shown = re.findall(r'<section id="(\w+)"', page)
    assert shown == ["shots", *STAGES]


def test_running_twice_writes_the_same_bytes(tmp_path):
    make_reports(tmp_path)

    assert run_report(tmp_path).read_bytes() == run_report(tmp_path).read_bytes()


def test_as_many_shots_are_shown_as_asked_for(tmp_path):
    make_reports(tmp_path)

    assert run_report(tmp_path, shots=1).read_text().count("<option>") == 1


@pytest.mark.parametrize("stage", STAGES)
def test_missing_stage_is_named_and_nothing_is_written(tmp_path, stage):
    make_reports(tmp_path)
    (tmp_path / "reports" / stage / "contents.json").unlink()

    with pytest.raises(InputError, match=f"run `dvc repro {stage}` first"):
        run_report(tmp_path)
    assert not (tmp_path / "reports" / "index.html").exists()
