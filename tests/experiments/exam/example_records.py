"""Exam records: those of the whole exam, and some that no trial has given."""

from functools import cache
from pathlib import Path

from experiments.exam.interface import NamedCause
from experiments.exam.records import RECORDS, AnswerRecord, ExamRecord, HiddenCause, read_records

COMMITTED = Path(__file__).parents[3] / RECORDS


@cache
def committed():
    return read_records(COMMITTED)


def hidden(identity="wind.x", value=0.3, indistinguishable=()):
    return HiddenCause(
        identity=identity,
        kind="missing_effect",
        nominal=0.0,
        value=value,
        indistinguishable=indistinguishable,
    )


def named(identity="wind.x", estimate=0.3, margin=0.02, possible=None):
    return NamedCause(
        identity=identity,
        estimate=estimate,
        interval=None if margin is None else (estimate - margin, estimate + margin),
        possible=possible or (identity,),
    )


def answer(conclusion, *causes, after=0.5):
    return AnswerRecord(conclusion=conclusion, causes=causes, gap_after_mm=after)


def record(*truth, group="sweep", cell="base", answers=None, before=10.0, **settings):
    """A record that hides ``truth``; ``answers`` is the one of rallygap."""
    details = {
        "name": f"{group}/example",
        "dynamics": "catalogue",
        "multiple": 3.0,
        "shots": 100,
        "noise": 0.003,
        "spin_labels": "per_row",
        "directions": 2,
        "withheld": (),
        "parameters": tuple(cause.identity for cause in truth),
        **settings,
    }
    gap = before if truth else None
    given = {"rallygap": answers} if answers else {}
    return ExamRecord(
        group=group, cell=cell, hidden=truth, gap_before_mm=gap, answers=given, **details
    )
