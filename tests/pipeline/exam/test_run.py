"""The whole exam: when its sheets are stale, and what verdicts cost."""

import json
import shutil
from pathlib import Path

import pytest

import pipeline.exam.run
from pipeline.exam.records import SHEETS, Sat, read_sheets
from pipeline.exam.run import fingerprint, sit_exam, verdict_costs
from pipeline.params import load_params
from tests.models.exam.sheets import sheet, whole_exam

REPOSITORY = Path(__file__).parents[3]


def params(**changes):
    repository = load_params(REPOSITORY / "params.yaml")
    settings = repository.hidden_effects.model_copy(update=changes)
    return repository.model_copy(update={"hidden_effects": settings})


@pytest.fixture
def root(tmp_path):
    """A repository with one file of code."""
    shutil.copy(REPOSITORY / "params.yaml", tmp_path)
    (tmp_path / "models/gap").mkdir(parents=True)
    (tmp_path / "models/gap/a.py").write_text("a = 1\n")
    (tmp_path / "constraints.txt").write_text("numpy==1\n")
    return tmp_path


def test_the_fingerprint_follows_what_shapes_sheets_and_nothing_else(root):
    before = fingerprint(root, params())

    assert fingerprint(root, params(trials=7)) == before
    assert fingerprint(root, params(peers_every=7)) != before
    (root / "README.md").write_text("other words\n")
    assert fingerprint(root, params()) == before
    (root / "models/gap/a.py").write_text("a = 2\n")
    assert fingerprint(root, params()) != before


def test_costs_are_of_cpu_seconds_by_method_and_shots():
    few, many = sheet(shots=10), sheet(shots=100)
    seconds = [(few, 1.0), (many, 4.0), (many, 6.0)]
    table = verdict_costs([Sat(sheet=one, seconds={"rallygap": s}) for one, s in seconds])

    rows = table.set_index("shots")
    assert rows["verdicts"].to_dict() == {10: 1, 100: 2}
    assert rows["cpu_s_median"].to_dict() == {10: 1.0, 100: 5.0}
    assert rows["cpu_s_total"].to_dict() == {10: 1.0, 100: 10.0}


def test_the_exam_leaves_its_sheets_and_what_they_cost(root, monkeypatch):
    sheets = whole_exam(every=100)
    sat = [Sat(sheet=one, seconds={"rallygap": 2.0}) for one in sheets]
    monkeypatch.setattr(pipeline.exam.run, "sit_all", lambda seats, folder: sat)
    (root / "scratch/exam/of before").mkdir(parents=True)

    sit_exam(root)
    assert not (root / "scratch/exam").exists()
    assert read_sheets(root / SHEETS) == sheets
    assert "rallygap" in (root / "reports/costs/verdicts.csv").read_text()
    assert json.loads((root / "reports/costs/verdicts.json").read_text())["cores"] >= 1
