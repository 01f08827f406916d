"""Answers of methods in words."""

from collections.abc import Sequence

import pandas as pd

from experiments.exam.interface import NamedCause
from experiments.exam.records import ExamRecord
from experiments.exam.scoring.rates import mark, solved


def methods_of(records: Sequence[ExamRecord]) -> list[str]:
    """Return the methods that answered, in their order."""
    return list(dict.fromkeys(method for record in records for method in record.answers))


def answer_rows(records: Sequence[ExamRecord], methods: Sequence[str]) -> pd.DataFrame:
    """Return one row a question and method: hidden causes, answer, mark."""
    rows = [
        (
            record.name,
            method,
            " + ".join(f"{cause.identity}={cause.value:.4g}" for cause in record.hidden)
            or "nothing",
            answer.conclusion or answer.error,
            " + ".join(map(_described, answer.causes)),
            mark(record, method),
            solved(record, method),
        )
        for record in records
        for method in methods
        if (answer := record.answers.get(method)) is not None
    ]
    columns = ["trial", "method", "hidden", "answer", "causes", "mark", "solved"]
    return pd.DataFrame(rows, columns=columns)


def _described(cause: NamedCause) -> str:
    others = [name for name in cause.possible if name != cause.identity]
    alternatives = f" (or {', '.join(others)})" if others else ""
    return f"{cause.identity}={cause.estimate:.4g}{alternatives}"
