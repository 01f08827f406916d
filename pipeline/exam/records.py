"""Sheets of the exam: filled in side by side, a small file each, and kept in one file of lines."""

import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from zlib import crc32

from pydantic import BaseModel, ValidationError

from models.exam.answer import Method
from models.exam.design.questions import Question, exam
from models.exam.methods.registry import METHODS
from models.exam.record import Sheet
from models.exam.run_question import sit
from pipeline.io.artifacts import read_as, write_text
from pipeline.io.simulators import load_simulator
from pipeline.params import Params
from pipeline.runtime.errors import InputError
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar

SHEETS = Path("reports") / "exam" / "sheets.jsonl"  # of the whole exam, in the repository
OURS = "rallygap"  # among the methods

Seat = tuple[Question, Mapping[str, Method]]  # what is asked, and who answers


class Sat(BaseModel):
    """A sheet, and the CPU seconds that each method took to answer."""

    sheet: Sheet
    seconds: dict[str, float]


def seats(params: Params) -> list[Seat]:
    """Return all questions, and who answers each: our method all, the others one in so many."""
    settings = params.hidden_effects
    questions = exam(load_simulator(settings.simulator), params.seed)
    ours = {OURS: METHODS[OURS]}
    return [
        # By the name, so that it has nothing to do with the place in the exam.
        (one, ours if crc32(one.trial.name.encode()) % settings.peers_every else METHODS)
        for one in questions
    ]


def sit_all(seats: Sequence[Seat], folder: Path) -> list[Sat]:
    """Let methods answer questions, side by side.

    Every sheet is left as a file, so that a killed run goes on where it was.

    Args:
        seats: the questions, and who answers each.
        folder: of these files; it belongs to these seats and to what shapes their sheets alone.
    """
    files = [folder / f"{question.trial.name.replace('/', '.')}.json" for question, _ in seats]
    waiting = [(*seat, file) for seat, file in zip(seats, files, strict=True) if not file.exists()]
    with progress_bar("exam", len(seats), len(seats) - len(waiting)) as advance:
        for _ in parallel([partial(_sit, *one) for one in waiting]):
            advance()
    return [read_as(file, Sat, "hidden_effects") for file in files]


def _sit(question: Question, methods: Mapping[str, Method], file: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what methods are in doubt about would hide the progress
        sheet, seconds = sit(question, methods)
    write_text(file, Sat(sheet=sheet, seconds=seconds).model_dump_json(exclude_defaults=True))


def write_sheets(path: Path, sheets: Sequence[Sheet]) -> None:
    """Write sheets, one a line."""
    lines = (one.model_dump_json(exclude_defaults=True) for one in sheets)
    write_text(path, "".join(f"{line}\n" for line in lines))


def read_sheets(path: Path) -> list[Sheet]:
    """Read sheets that ``write_sheets`` wrote.

    Raises:
        InputError: there is no such file, nothing in it, or a line of it is no sheet.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise InputError(path, "there is no such file; run `make exam`") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read as text: {error}") from None
    if not lines:
        raise InputError(path, "has no sheet; run `make exam`")
    return [_sheet(path, row, line) for row, line in enumerate(lines, start=1)]


def _sheet(path: Path, row: int, line: str) -> Sheet:
    try:
        return Sheet.model_validate_json(line)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or None
        raise InputError(path, f"{first['msg']}; run `make exam`", row=row, field=field) from None
