"""Running questions of the exam, each result a file."""

import hashlib
import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from zlib import crc32

from pydantic import BaseModel

from rallygap.models.exam.design.question import Question, seed_of
from rallygap.models.exam.design.questions import exam
from rallygap.models.exam.interface import Method
from rallygap.models.exam.methods.registry import METHODS, RALLYGAP
from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.runner import run_question
from rallygap.pipeline.experiments.file_content import effective_content
from rallygap.pipeline.io.artifacts import read_as, write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.provenance import short

# What records depend on: packages of ``models``, and the versions of libraries that calculate.
PACKAGES = ("models/arena", "models/ball", "models/exam", "models/gap")
LIBRARIES = ("llvmlite", "numba", "numpy", "pysindy", "scikit-learn", "scipy")
Assignment = tuple[Question, Mapping[str, Method]]  # a question, and the methods that answer it


class Result(BaseModel):
    """The record of a question, and the CPU seconds that each method took."""

    record: ExamRecord
    seconds: dict[str, float]


def assignments(params: Params) -> list[Assignment]:
    """Return all questions with their methods: rallygap answers all, the others one in so many."""
    settings = params.hidden_effects
    questions = exam(load_simulator(settings.simulator), _seed(params))
    only_rallygap = {RALLYGAP: METHODS[RALLYGAP]}
    return [
        # By a hash of the name, which does not depend on the place in the exam.
        (
            question,
            only_rallygap
            if crc32(question.trial.name.encode()) % settings.other_methods_every
            else METHODS,
        )
        for question in questions
    ]


def _seed(params: Params) -> int:
    """Return the seed of all questions of an edition."""
    return seed_of(params.seed, f"edition {params.hidden_effects.edition}")


def run_questions(assignments: Sequence[Assignment], folder: Path) -> list[Result]:
    """Run questions in parallel. Each result is a file, so that a killed run resumes.

    Args:
        assignments: the questions and their methods.
        folder: of these files, for these assignments and the code that they depend on only.
    """
    pending = [one for one in assignments if not _file(folder, one).exists()]
    tasks = [partial(_run, *one, _file(folder, one)) for one in pending]
    for _ in parallel(tasks, "exam", done=len(assignments) - len(pending)):
        pass
    return finished(assignments, folder)


def finished(assignments: Sequence[Assignment], folder: Path) -> list[Result]:
    """Return the results, in a folder, of those questions that were asked."""
    files = [_file(folder, one) for one in assignments]
    return [read_as(file, Result, "hidden_effects") for file in files if file.exists()]


def _file(folder: Path, assignment: Assignment) -> Path:
    return folder / f"{assignment[0].trial.name.replace('/', '.')}.json"


def _run(question: Question, methods: Mapping[str, Method], file: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numerical warnings of methods would hide the progress
        record, seconds = run_question(question, methods)
    result = Result(record=record, seconds=seconds)
    write_text(file, result.model_dump_json(exclude_defaults=True))


def code_of_records(root: Path, params: Params) -> str:
    """Return a short digest of all that records depend on: not of comments and docstrings."""
    digest = hashlib.sha256()
    settings = params.hidden_effects
    simulator = load_simulator(settings.simulator).to_dict()
    values = [_seed(params), settings.other_methods_every, simulator]
    digest.update(json.dumps(values, sort_keys=True).encode())
    for name in PACKAGES:
        for path in sorted((root / name).rglob("*.py")):
            code = effective_content(path.name, path.read_text(encoding="utf-8"))
            digest.update(path.relative_to(root).as_posix().encode() + code.encode())
    for line in _versions(root / "constraints.txt"):
        digest.update(line.encode())
    return short(digest.hexdigest())


def _versions(constraints: Path) -> Iterator[str]:
    """Yield the lines of the libraries that records depend on."""
    for line in constraints.read_text(encoding="utf-8").splitlines():
        if line.partition("==")[0].lower() in LIBRARIES:
            yield line
