"""The stage reports what the kept sheets say, and whether questions sat anew agree."""

import json

import joblib
import pandas as pd
import pytest

import stages.hidden_effects
from models.exam.answer import Finding
from models.exam.design.questions import Question
from models.exam.design.trial import Trial
from models.exam.record import Answered
from models.exam.run_question import sit
from pipeline.exam.records import SHEETS, write_sheets
from pipeline.runtime.errors import InputError
from pipeline.runtime.stage_run import StageRun
from stages.hidden_effects import hidden_effects
from tests.models.exam.halls import NOMINAL
from tests.models.exam.sheets import whole_exam
from tests.pipeline.measured_shots import params

REPORTED = {
    "clean_sets", "false_alarms", "false_alarm_rate", "false_alarm_upper95", "top1_at_3x",
    "class_at_3x", "pairs_both", "unknown_recall", "coverage", "removable_closed",
}  # fmt: skip


def nothing(recordings, nominal, withheld):
    return Finding("no_gap", (), nominal)


METHODS = {"rallygap": nothing, "sindy": nothing}
QUESTION = Question("clean", Trial("clean/made up", NOMINAL, shots=3, seed=1004))


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """One question, to methods that find nothing, in this process."""
    monkeypatch.setattr(stages.hidden_effects, "seats", lambda params: [(QUESTION, METHODS)])
    with joblib.parallel_config(backend="sequential"):
        yield


def reported(root, *more):
    sheet, _ = sit(QUESTION, METHODS)
    write_sheets(root / SHEETS, [*whole_exam(every=20), *(more or [sheet])])
    run = StageRun("hidden_effects", root, params())
    hidden_effects(run)
    return run


def test_rates_of_our_method_stand_on_top_and_those_of_others_below(tmp_path):
    run = reported(tmp_path)
    results = json.loads(run.report("exam.json").read_text())

    assert set(results) >= REPORTED
    assert set(results["compared"]) == {"sindy"}
    assert set(results["compared"]["sindy"]) >= REPORTED
    assert results["questions"] == len(whole_exam(every=20)) + 1
    metrics = json.loads(run.report("metrics.json").read_text())
    assert metrics["exam"]["top1_at_3x"] == results["top1_at_3x"]
    assert metrics["sat_anew"] == {"trials": 1, "differing": 0}


def test_answers_that_are_no_longer_given_are_told(tmp_path, capsys):
    sheet, _ = sit(QUESTION, METHODS)
    other = sheet.model_copy(update={"answers": {"rallygap": Answered(answer="unknown")}})
    run = reported(tmp_path, other)

    assert run.metrics["sat_anew"]["differing"] == 1
    assert not pd.read_csv(run.report("sat_anew.csv"))["as_kept"].any()
    assert "run `make exam`" in capsys.readouterr().err


def test_the_same_sheets_give_the_same_bytes_and_times_go_elsewhere(tmp_path):
    first, second = (reported(tmp_path / name) for name in ("once", "again"))
    written = sorted(first.report("exam.json").parent.rglob("*.*"))

    assert {path.suffix for path in written} == {".json", ".csv", ".png"}
    for path in written:
        again = tmp_path / "again" / path.relative_to(tmp_path / "once")
        assert path.read_bytes() == again.read_bytes()
    assert set(first.timings) == {"rallygap_cpu_s_median", "sindy_cpu_s_median"}
    assert "seconds" not in second.report("exam.json").read_text()


def test_without_sheets_there_is_one_error_and_no_report(tmp_path):
    with pytest.raises(InputError, match="run `make exam`"):
        hidden_effects(StageRun("hidden_effects", tmp_path, params()))
    assert not (tmp_path / "reports").exists()
