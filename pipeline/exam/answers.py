"""Answers of methods in words."""

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from rallygap.models.exam.records import AnswerRecord, ExamRecord
from rallygap.models.exam.scoring.rates import mark, solved


def methods_of(records: Sequence[ExamRecord]) -> list[str]:
    """Return the methods that answered, in their order."""
    return list(dict.fromkeys(method for record in records for method in record.answers))


def answer_rows(records: Sequence[ExamRecord], methods: Sequence[str]) -> pd.DataFrame:
    """Return one row a question and method: hidden causes, answer, mark."""
    columns = ["trial", "method", "hidden", "answer", "causes", "mark", "solved"]
    rows = [
        _answer_row(record, method)
        for record in records
        for method in methods
        if method in record.answers
    ]
    return pd.DataFrame(rows, columns=columns)


def _answer_row(record: ExamRecord, method: str) -> dict[str, Any]:
    answer = record.answers[method]
    hidden = (f"{cause.identity}={cause.value:.4g}" for cause in record.hidden)
    return {
        "trial": record.name,
        "method": method,
        "hidden": " + ".join(hidden) or "nothing",
        "answer": answer.conclusion or answer.error,
        "causes": " + ".join(_causes(answer)),
        "mark": mark(record, method),
        "solved": solved(record, method),
    }


def _causes(answer: AnswerRecord) -> Iterator[str]:
    for cause in answer.causes:
        others = [name for name in cause.possible if name != cause.identity]
        alternatives = f" (or {', '.join(others)})" if others else ""
        yield f"{cause.identity}={cause.estimate:.4g}{alternatives}"
