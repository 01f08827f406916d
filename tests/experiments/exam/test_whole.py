"""Runs of questions resume, and the whole exam leaves records and costs."""

import json
import shutil
from collections import Counter
from pathlib import Path

import joblib
import numpy as np
import pandas as pd
import pytest

import experiments.exam_sample
import experiments.stages.exam
from experiments.exam.design.question import Question, seed_of
from experiments.exam.design.questions import exam
from experiments.exam.interface import Answer
from experiments.exam.methods.registry import METHODS, RALLYGAP
from experiments.exam.records import RECORDS, read_records, write_records
from experiments.exam.simulate.trial import Trial
from experiments.exam.whole import assignments
from experiments.exam_sample import run_sample
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.experiments.exam.example_records import COMMITTED, committed, record
from tests.experiments.exam.example_trials import NOMINAL

REPOSITORY = Path(__file__).parents[3]
NAMES = ["clean/0", "clean/1", "clean/2"]


def params(**changes):
    repository = load_params(REPOSITORY / "params.yaml")
    settings = repository.exam.model_copy(update=changes)
    return repository.model_copy(update={"exam": settings})


class Counting:
    """A method that counts its calls, and is killed after some."""

    def __init__(self, killed_after=1000):
        self.calls, self.killed_after = 0, killed_after

    def __call__(self, recordings, nominal, withheld):
        if self.calls == self.killed_after:
            raise KeyboardInterrupt
        self.calls += 1
        return Answer("no_gap", (), nominal)


def asked(method):
    trials = [Trial(name, NOMINAL, shots=3, seed=1003) for name in NAMES]
    return [(Question("clean", trial), {RALLYGAP: method}) for trial in trials]


@pytest.fixture(autouse=True)
def _one_process():
    with joblib.parallel_config(backend="sequential"):
        yield


def test_rallygap_answers_every_question_and_the_others_one_in_so_many():
    settings = params()
    chosen = settings.exam
    assigned, next_edition = assignments(settings), assignments(params(edition=chosen.edition + 1))
    seed = seed_of(settings.seed, f"edition {chosen.edition}")
    assert [question for question, _ in assigned] == exam(load_simulator(chosen.simulator), seed)
    assert all(RALLYGAP in methods for _, methods in assigned)
    share = np.mean([methods == METHODS for _, methods in assigned])
    assert share == pytest.approx(1 / chosen.other_methods_every, rel=0.15)
    # Every edition asks its own questions of the same kinds.
    first, second = ([question for question, _ in asked] for asked in (assigned, next_edition))
    assert not {one.trial.seed for one in first} & {one.trial.seed for one in second}
    assert Counter(one.group for one in first) == Counter(one.group for one in second)


@pytest.fixture
def root(tmp_path):
    """A repository with parameters alone."""
    shutil.copy(REPOSITORY / "params.yaml", tmp_path)
    return tmp_path


def run_with(method, root, monkeypatch):
    """Run an exam of three questions; return how many of them a method is asked."""
    monkeypatch.setattr(experiments.stages.exam, "assignments", lambda _: asked(method))
    experiments.stages.exam.exam(StageRun("exam", root, params()))
    return method.calls


def test_a_stopped_exam_continues_and_leaves_records_and_costs(root, monkeypatch):
    with pytest.raises(KeyboardInterrupt):
        run_with(Counting(killed_after=2), root, monkeypatch)
    assert not (root / RECORDS).exists()

    assert run_with(Counting(), root, monkeypatch) == 1
    records = read_records(root / RECORDS)
    assert [record.name for record in records] == NAMES
    (costs,) = pd.read_csv(root / "reports/exam/costs.csv").to_dict("records")
    assert costs == costs | {"method": RALLYGAP, "shots": 3, "verdicts": 3}
    seconds = sum(record.seconds[RALLYGAP] for record in records)
    assert costs["cpu_s_total"] == pytest.approx(seconds, rel=1e-2)
    assert json.loads((root / "reports/exam/metrics.json").read_text())["false_alarm_rate"] == 0


def test_a_sample_is_some_questions_of_some_groups(root, monkeypatch):
    def run(assignments, folder):
        return [record(name=question.trial.name) for question, _ in assignments]

    def sampled(groups, every):
        run_sample(root, root / "sample.jsonl", groups, every)
        return [one.name for one in read_records(root / "sample.jsonl")]

    monkeypatch.setattr(experiments.exam_sample, "run_questions", run)
    known = [question.trial.name for question, _ in assignments(params())]
    names = sampled(["distortion", "several"], 6)
    assert names == [one for one in known if one.startswith(("distortion", "several"))][::6]
    assert not (root / RECORDS).exists()
    assert sampled([], 100) == known[::100]
    with pytest.raises(InputError, match="there is no group 'tilt'; groups: sweep"):
        sampled(["tilt"], 1)


def test_records_that_are_read_are_written_to_the_same_bytes(tmp_path):
    write_records(tmp_path / "records.jsonl", committed())
    assert (tmp_path / "records.jsonl").read_bytes() == COMMITTED.read_bytes()
    assert record(noise=0.00300000049).noise == 0.003


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "there is no such file; run `python -m experiments.stages.exam`"),
        ("", "has no record; run `python -m experiments.stages.exam`"),
        ("{}\n", r"row 1, name: Field required; run `python -m experiments.stages.exam`"),
        ("no json\n", "row 1: Invalid JSON"),
    ],
)
def test_a_damaged_file_is_one_error(tmp_path, content, problem):
    path = tmp_path / "records.jsonl"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=problem):
        read_records(path)
