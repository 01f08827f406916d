"""Runs of questions resume, and the whole exam leaves records and costs."""

import json
import shutil
from collections import Counter
from pathlib import Path

import joblib
import numpy as np
import pytest

import rallygap.pipeline.exam.full_run
from rallygap.models.exam.design.question import Question, seed_of
from rallygap.models.exam.design.questions import exam
from rallygap.models.exam.interface import Answer
from rallygap.models.exam.methods.registry import METHODS, RALLYGAP
from rallygap.models.exam.simulate.trial import Trial
from rallygap.pipeline.exam.full_run import main, run_exam, run_sample, verdict_costs
from rallygap.pipeline.exam.records import RECORDS, UNFINISHED, read_records, write_records
from rallygap.pipeline.exam.run import Result, assignments, code_of_records, run_questions
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.errors import InputError
from tests.models.exam.example_records import record
from tests.models.exam.example_trials import NOMINAL

REPOSITORY = Path(__file__).parents[3]
NAMES = ["clean/0", "clean/1", "clean/2"]


def params(**changes):
    repository = load_params(REPOSITORY / "params.yaml")
    settings = repository.hidden_effects.model_copy(update=changes)
    return repository.model_copy(update={"hidden_effects": settings})


class Counting:
    """A method that counts its calls, and is killed after some."""

    def __init__(self, killed_after=1000):
        self.calls, self.killed_after = 0, killed_after

    def __call__(self, recordings, nominal, withheld):
        if self.calls == self.killed_after:
            raise KeyboardInterrupt
        self.calls += 1
        return Answer("no_gap", (), nominal)


def run(method, folder):
    trials = [Trial(name, NOMINAL, shots=3, seed=1003) for name in NAMES]
    with joblib.parallel_config(backend="sequential"):
        return run_questions([(Question("clean", one), {"m": method}) for one in trials], folder)


def test_rallygap_answers_every_question_and_the_others_one_in_so_many():
    settings = params()
    assigned = assignments(settings)

    hidden = settings.hidden_effects
    seed = seed_of(settings.seed, f"edition {hidden.edition}")
    assert [question for question, _ in assigned] == exam(load_simulator(hidden.simulator), seed)
    assert all(RALLYGAP in methods for _, methods in assigned)
    share = np.mean([methods == METHODS for _, methods in assigned])
    assert share == pytest.approx(1 / settings.hidden_effects.other_methods_every, rel=0.15)


def test_every_edition_asks_its_own_questions_of_the_same_kinds():
    first, second = ([one for one, _ in assignments(params(edition=n))] for n in (1, 2))

    assert not {one.trial.seed for one in first} & {one.trial.seed for one in second}
    assert Counter(one.group for one in first) == Counter(one.group for one in second)


def test_a_killed_run_resumes(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(Counting(killed_after=2), tmp_path)
    again = Counting()
    results = run(again, tmp_path)

    assert again.calls == 1
    assert [result.record.name for result in results] == NAMES
    assert all(result.seconds.keys() == {"m"} for result in results)
    assert results == run(Counting(), tmp_path)


def test_a_damaged_file_of_a_killed_run_is_named(tmp_path):
    run(Counting(), tmp_path)
    (tmp_path / "clean.1.json").write_text("{}")

    with pytest.raises(InputError, match=r"clean\.1\.json"):
        run(Counting(), tmp_path)


@pytest.fixture
def root(tmp_path):
    """A repository with one file of code."""
    shutil.copy(REPOSITORY / "params.yaml", tmp_path)
    (tmp_path / "models/gap").mkdir(parents=True)
    (tmp_path / "models/gap/a.py").write_text("a = 1\n")
    (tmp_path / "constraints.txt").write_text("numpy==1\n")
    return tmp_path


def test_the_code_of_records_follows_what_records_depend_on_and_nothing_else(root):
    before = code_of_records(root, params())

    assert code_of_records(root, params(rerun_questions=7)) == before
    assert code_of_records(root, params(edition=7)) != before
    assert code_of_records(root, params(other_methods_every=7)) != before
    (root / "README.md").write_text("other words\n")
    (root / "constraints.txt").write_text("numpy==1\nmlflow==2\n")
    assert code_of_records(root, params()) == before
    (root / "constraints.txt").write_text("numpy==2\nmlflow==2\n")
    assert code_of_records(root, params()) != before
    (root / "constraints.txt").write_text("numpy==1\n")
    (root / "models/gap/a.py").write_text("# A number.\na = 1\n")
    assert code_of_records(root, params()) == before
    (root / "models/gap/a.py").write_text("a = 2\n")
    assert code_of_records(root, params()) != before


def test_costs_are_cpu_seconds_by_method_and_shots():
    few, many = record(shots=10), record(shots=100)
    seconds = [(few, 1.0), (many, 4.0), (many, 6.0)]
    table = verdict_costs([one.model_copy(update={"seconds": {RALLYGAP: s}}) for one, s in seconds])

    rows = table.set_index("shots")
    assert rows["verdicts"].to_dict() == {10: 1, 100: 2}
    assert rows["cpu_s_median"].to_dict() == {10: 1.0, 100: 5.0}
    assert rows["cpu_s_total"].to_dict() == {10: 1.0, 100: 10.0}


class Asked:
    """Answers questions at once; stopped with Ctrl-C after some."""

    def __init__(self, monkeypatch, stopped_after=1000):
        self.names, self.stopped_after = [], stopped_after
        monkeypatch.setattr(rallygap.pipeline.exam.full_run, "run_questions", self)

    def __call__(self, assignments, folder):
        for question, _ in assignments:
            if len(self.names) == self.stopped_after:
                raise KeyboardInterrupt
            name = question.trial.name
            self.names.append(name)
            result = Result(record=record(name=name), seconds={RALLYGAP: 2.0})
            write_text(folder / f"{name.replace('/', '.')}.json", result.model_dump_json())


@pytest.fixture
def few(monkeypatch):
    """An exam of a few questions."""
    asked = assignments(params())[::400]
    monkeypatch.setattr(rallygap.pipeline.exam.full_run, "assignments", lambda params: asked)
    return [question.trial.name for question, _ in asked]


def test_the_exam_leaves_records_and_costs(root, few, monkeypatch):
    Asked(monkeypatch)
    (root / "scratch/exam/older").mkdir(parents=True)

    run_exam(root)
    assert not (root / "scratch/exam").exists()
    records = read_records(root / RECORDS)
    assert [one.name for one in records] == few
    assert {one.code for one in records} == {code_of_records(root, params())}
    assert RALLYGAP in (root / "reports/costs/verdicts.csv").read_text()
    assert json.loads((root / "reports/costs/verdicts.json").read_text())["cores"] >= 1


def test_the_next_run_continues_a_stopped_exam_and_no_file_mixes_records_of_two_codes(
    root, few, monkeypatch
):
    earlier = [record(name=few[0]), record(name="of another exam")]
    write_records(root / RECORDS, earlier)
    with pytest.raises(KeyboardInterrupt):
        run_exam_with(Asked(monkeypatch, stopped_after=2), root)
    code = code_of_records(root, params())
    kept = [(one.name, one.code) for one in read_records(root / UNFINISHED)]
    assert kept == [(few[0], code), (few[1], code)]
    assert read_records(root / RECORDS) == earlier
    shutil.rmtree(root / "scratch")  # records are enough to continue from

    assert run_exam_with(Asked(monkeypatch), root) == few[2:]
    assert [one.name for one in read_records(root / RECORDS)] == few
    assert {one.code for one in read_records(root / RECORDS)} == {code}
    assert not (root / UNFINISHED).exists()


def test_unfinished_records_of_earlier_code_are_made_again(root, few, monkeypatch):
    write_records(root / UNFINISHED, [record(name=few[0])])

    assert run_exam_with(Asked(monkeypatch), root) == few
    assert run_exam_with(Asked(monkeypatch), root) == []


def test_an_exam_that_is_stopped_before_its_first_answer_can_be_continued(root, few, monkeypatch):
    with pytest.raises(KeyboardInterrupt):
        run_exam_with(Asked(monkeypatch, stopped_after=0), root)

    assert run_exam_with(Asked(monkeypatch), root) == few


def run_exam_with(asked, root):
    """Run the exam; return which questions were asked."""
    run_exam(root)
    return asked.names


def sampled(root, monkeypatch, groups, every):
    """Names of the questions of a sample, and the folder of their results."""
    calls = []

    def run(assignments, folder):
        calls.append(folder)
        return [Result(record=record(name=q.trial.name), seconds={}) for q, _ in assignments]

    monkeypatch.setattr(rallygap.pipeline.exam.full_run, "run_questions", run)
    run_sample(root, root / "sample.jsonl", groups, every)
    return [one.name for one in read_records(root / "sample.jsonl")], calls[0]


def test_a_sample_is_some_questions_of_some_groups(root, monkeypatch):
    names, folder = sampled(root, monkeypatch, ["distortion", "several"], 6)
    known = [q.trial.name for q, _ in assignments(params())]

    assert names == [one for one in known if one.startswith(("distortion", "several"))][::6]
    assert len(names) == 20
    assert folder.parent == root / "scratch/exam"
    assert not (root / RECORDS).exists()
    everything, again = sampled(root, monkeypatch, [], 100)
    assert (everything, again) == (known[::100], folder)


def test_an_unknown_group_is_one_error(root):
    with pytest.raises(InputError, match="there is no group 'tilt'; groups: sweep"):
        run_sample(root, root / "sample.jsonl", ["tilt"], 1)


@pytest.mark.parametrize("arguments", [["--groups", "several"], ["--every", "6"]])
def test_a_sample_needs_a_file_of_its_own(arguments, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["full_run", *arguments])

    with pytest.raises(SystemExit):
        main()
    assert "a sample needs --out" in capsys.readouterr().err
