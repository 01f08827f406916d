"""The stage reports the kept records, and whether questions that are run again agree."""

import json

import joblib
import pandas as pd
import pytest

import rallygap.stages.hidden_effects
from rallygap.models.exam.design.question import Question
from rallygap.models.exam.interface import Answer
from rallygap.models.exam.records import AnswerRecord
from rallygap.models.exam.runner import run_question
from rallygap.models.exam.simulate.trial import Trial
from rallygap.pipeline.exam.records import RECORDS, write_records
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.hidden_effects import hidden_effects
from tests.models.exam.example_records import example_exam
from tests.models.exam.example_trials import NOMINAL
from tests.pipeline.measured_shots import params
from tests.stages.outputs import written

REPORTED = {
    "clean_sets", "false_alarms", "false_alarm_rate", "false_alarm_upper95", "top1_at_3x",
    "class_at_3x", "pairs_both", "unknown_recall", "coverage", "removable_closed",
    "false_leading_rate", "leading_at_3x", "exact_at_3x", "coverage_new", "unknown_recall_new",
}  # fmt: skip


def no_gap(recordings, nominal, withheld):
    return Answer("no_gap", (), nominal)


METHODS = {"rallygap": no_gap, "sindy": no_gap}
QUESTION = Question("clean", Trial("clean/example", NOMINAL, shots=3, seed=1004))


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """One question, for methods that name nothing, in this process."""
    monkeypatch.setattr(
        rallygap.stages.hidden_effects, "assignments", lambda params: [(QUESTION, METHODS)]
    )
    with joblib.parallel_config(backend="sequential"):
        yield


def reported(root, *more):
    record = run_question(QUESTION, METHODS)
    write_records(root / RECORDS, [*example_exam(every=20), *(more or [record])])
    run = StageRun("hidden_effects", root, params())
    hidden_effects(run)
    return run


def test_rates_of_rallygap_come_first_and_those_of_others_below(tmp_path):
    run = reported(tmp_path)
    results = json.loads(run.report("exam.json").read_text())

    assert set(results) >= REPORTED
    assert set(results["compared"]) == {"sindy"}
    assert set(results["compared"]["sindy"]) >= REPORTED
    assert results["questions"] + results["questions_new"] == len(example_exam(every=20)) + 1
    metrics = json.loads(run.report("metrics.json").read_text())
    assert metrics["exam"]["top1_at_3x"] == results["top1_at_3x"]
    assert metrics["rerun"] == {"questions": 1, "different": 0}


def test_answers_that_differ_from_the_records_are_reported(tmp_path, capsys):
    record = run_question(QUESTION, METHODS)
    unknown = {"rallygap": AnswerRecord(conclusion="unknown")}
    other = record.model_copy(update={"answers": unknown})
    run = reported(tmp_path, other)

    assert run.metrics["rerun"]["different"] == 1
    assert not pd.read_csv(run.report("rerun.csv"))["as_recorded"].any()
    assert "run `make exam`" in capsys.readouterr().err


def test_the_same_records_give_the_same_bytes_and_times_go_elsewhere(tmp_path):
    first, second = (reported(tmp_path / name) for name in ("once", "again"))

    assert written(first) == written(second)
    assert set(first.timings) == {"rallygap_cpu_s_median", "sindy_cpu_s_median"}
    assert "seconds" not in second.report("exam.json").read_text()


def test_without_records_there_is_one_error_and_no_report(tmp_path):
    with pytest.raises(InputError, match="run `make exam`"):
        hidden_effects(StageRun("hidden_effects", tmp_path, params()))
    assert not (tmp_path / "reports").exists()


def test_questions_without_a_record_are_not_run_again(tmp_path, monkeypatch, capsys):
    other = Question("clean", Trial("clean/other", NOMINAL, shots=3, seed=1004))
    asked = [(QUESTION, METHODS), (other, METHODS)]
    monkeypatch.setattr(rallygap.stages.hidden_effects, "assignments", lambda params: asked)
    run = reported(tmp_path)

    assert run.metrics["rerun"] == {"questions": 1, "different": 0}
    assert "1 questions have no record; run `make exam`" in capsys.readouterr().err
