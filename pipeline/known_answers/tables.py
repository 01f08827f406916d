"""The table of all questions and their answers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.gap.verdict import Cause, Gap
from rallygap.pipeline.gap.wording import interval_text
from rallygap.pipeline.known_answers.scores import Answer
from rallygap.pipeline.web.numbers import number

COLUMNS = [
    *("set", "fold", "place", "planted", "size", "value"),
    *("true", "verdict", "causes", "leading", "by_name", "exact", "covered", "false"),
    *("before_mm", "after_mm", "floor_mm"),
]


def answer_table(answers: Sequence[Answer]) -> pd.DataFrame:
    """Return one row a question.

    ``value`` is what was planted, in the parameter's unit or m, ``true`` what a correct verdict
    finds, ``causes`` the main causes, each with the parameters that the shots cannot separate from
    it. Scores are empty where a question has none. Errors are means over the horizons.
    """
    return pd.DataFrame([_row(one) for one in answers], columns=COLUMNS)


def _row(answer: Answer) -> dict[str, Any]:
    question, verdict = answer.question, answer.verdict
    return {
        "set": question.set,
        "fold": question.fold,
        **_planted(answer),
        "verdict": verdict.verdict,
        "causes": "; ".join(map(_cause_text, verdict.main_causes)),
        **_score(answer),
        **(_errors(verdict.gap) if verdict.gap else {}),
    }


def _planted(answer: Answer) -> dict[str, Any]:
    error = answer.question.error
    if error is None:
        return {"planted": "none"}
    truth = (f"{identity} {number(value)}" for identity, value in answer.truth.items())
    return {
        "place": error.place,
        "planted": error.identity,
        "size": error.size,
        "value": error.value,
        "true": "; ".join(truth),
    }


def _score(answer: Answer) -> dict[str, Any]:
    if not answer.is_planted:
        return {}
    false = "; ".join(cause.identity for cause in answer.false)
    if answer.is_distortion:
        return {"false": false}
    return {
        "leading": answer.leading,
        "by_name": answer.by_name,
        "exact": answer.exact,
        "covered": all(answer.covered) if answer.covered else None,
        "false": false,
    }


def _cause_text(cause: Cause) -> str:
    estimate = f"{cause.identity} {number(cause.estimate)} ({interval_text(cause.interval)})"
    return " or ".join([estimate, *cause.alternatives])


def _errors(gap: Gap) -> dict[str, float]:
    sizes = {"before_mm": gap.before_mm, "after_mm": gap.after_mm, "floor_mm": gap.floor_mm}
    return {name: float(np.mean(values)) for name, values in sizes.items()}
