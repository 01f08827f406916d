"""Running questions of the exam, each record a file until all are answered."""

import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from zlib import crc32

from experiments.exam.design.question import Question, seed_of
from experiments.exam.design.questions import exam
from experiments.exam.interface import Method
from experiments.exam.methods.registry import METHODS, RALLYGAP
from experiments.exam.records import ExamRecord
from experiments.exam.runner import run_question
from rallygap.pipeline.io.artifacts import read_as, write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.parallel import make_missing

Assignment = tuple[Question, Mapping[str, Method]]  # a question, and the methods that answer it


def assignments(params: Params) -> list[Assignment]:
    """Return all questions with their methods: rallygap answers all, the others one in so many."""
    settings = params.exam
    seed = seed_of(params.seed, f"edition {settings.edition}")
    only_rallygap = {RALLYGAP: METHODS[RALLYGAP]}

    def methods(question: Question) -> Mapping[str, Method]:
        # By a hash of the name, which does not depend on the place in the exam.
        number = crc32(question.trial.name.encode())
        return only_rallygap if number % settings.other_methods_every else METHODS

    questions = exam(load_simulator(settings.simulator), seed)
    return [(question, methods(question)) for question in questions]


def run_questions(assignments: Sequence[Assignment], folder: Path) -> list[ExamRecord]:
    """Run questions in parallel. Each record is a file, so that a killed run resumes.

    Args:
        assignments: the questions and their methods.
        folder: of these files, for these assignments and the code that they depend on only.
    """
    names = [question.trial.name.replace("/", ".") for question, _ in assignments]
    files = [folder / f"{name}.json" for name in names]
    tasks = {
        file: partial(_run, *assignment, file)
        for file, assignment in zip(files, assignments, strict=True)
    }
    make_missing(tasks, "exam")
    return [read_as(file, ExamRecord, "exam") for file in files]


def _run(question: Question, methods: Mapping[str, Method], file: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numerical warnings of methods would hide the progress
        record = run_question(question, methods)
    write_text(file, record.model_dump_json(exclude_defaults=True))
