"""Sheets: one file each while the exam is sat, one line each in the repository."""

import json
from pathlib import Path

import joblib
import numpy as np
import pytest

from models.exam.answer import Finding
from models.exam.design.questions import Question, exam
from models.exam.design.trial import Trial
from models.exam.methods.registry import METHODS
from pipeline.exam import records as exam_sheets
from pipeline.exam.records import Sat, read_sheets, sit_all, write_sheets
from pipeline.io.simulators import load_simulator
from pipeline.params import load_params
from pipeline.runtime.errors import InputError
from tests.models.exam.halls import NOMINAL
from tests.models.exam.sheets import whole_exam


def clean(name):
    return Question("clean", Trial(name, NOMINAL, shots=3, seed=1003))


class Counting:
    """A method that counts how often it is asked, and is killed when it was asked enough."""

    def __init__(self, killed_after=1000):
        self.asked, self.killed_after = 0, killed_after

    def __call__(self, recordings, nominal, withheld):
        if self.asked == self.killed_after:
            raise KeyboardInterrupt
        self.asked += 1
        return Finding("no_gap", (), nominal)


def seats(method):
    return [(clean(name), {"counting": method}) for name in ("clean/0", "clean/1", "clean/2")]


@pytest.fixture(autouse=True)
def _in_this_process():
    with joblib.parallel_config(backend="sequential"):
        yield


def test_every_question_is_asked_and_the_peers_one_in_so_many():
    repository = load_params(Path(__file__).parents[3] / "params.yaml")
    every = repository.hidden_effects.peers_every
    found = exam_sheets.seats(repository)

    simulator = load_simulator(repository.hidden_effects.simulator)
    assert [question for question, _ in found] == exam(simulator, repository.seed)
    assert all(exam_sheets.OURS in methods for _, methods in found)
    asked = np.mean([methods == METHODS for _, methods in found])
    assert asked == pytest.approx(1 / every, rel=0.15)


def test_sheets_come_in_the_order_of_the_questions(tmp_path):
    sat = sit_all(seats(Counting()), tmp_path)

    assert [one.sheet.name for one in sat] == ["clean/0", "clean/1", "clean/2"]
    assert all(one.seconds["counting"] >= 0.0 for one in sat)


def test_a_killed_exam_goes_on_where_it_was(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        sit_all(seats(Counting(killed_after=2)), tmp_path)
    again = Counting()
    sat = sit_all(seats(again), tmp_path)

    assert again.asked == 1
    assert sat == sit_all(seats(Counting()), tmp_path)


def test_a_broken_file_of_a_killed_exam_is_named(tmp_path):
    sit_all(seats(Counting()), tmp_path)
    (tmp_path / "clean.1.json").write_text("{}")

    with pytest.raises(InputError, match=r"clean\.1\.json"):
        sit_all(seats(Counting()), tmp_path)


def test_written_sheets_are_read_again(tmp_path):
    sheets = whole_exam(every=60)
    write_sheets(tmp_path / "sheets.jsonl", sheets)

    assert read_sheets(tmp_path / "sheets.jsonl") == sheets
    assert len((tmp_path / "sheets.jsonl").read_text().splitlines()) == len(sheets)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "there is no such file; run `make exam`"),
        ("", "has no sheet; run `make exam`"),
        ("{}\n", r"row 1, name: Field required; run `make exam`"),
        ("no json\n", "row 1: Invalid JSON"),
    ],
)
def test_what_is_no_sheet_is_one_error(tmp_path, content, problem):
    path = tmp_path / "sheets.jsonl"
    if content is not None:
        path.write_text(content)

    with pytest.raises(InputError, match=problem):
        read_sheets(path)


def test_numbers_are_written_with_six_digits(tmp_path):
    sheet = whole_exam(every=300)[0].model_copy(update={"noise": 0.003})
    content = json.loads(Sat(sheet=sheet, seconds={}).model_dump_json())

    again = Sat.model_validate({**content, "sheet": {**content["sheet"], "noise": 0.00300000049}})
    assert again.sheet.noise == 0.003
