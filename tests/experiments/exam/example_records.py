"""Exam records of trials that were never simulated, with any answers."""

import numpy as np

from experiments.exam.design.questions import exam
from experiments.exam.interface import NamedCause
from experiments.exam.records import AnswerRecord, ExamRecord, HiddenCause
from tests.experiments.exam.example_trials import NOMINAL

METHODS = ("rallygap", "sindy")
SIMILAR = {"gravity.g": ("buoyancy.b",), "buoyancy.b": ("gravity.g",)}


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
    """A record that hides ``truth``; ``answers`` is one for rallygap, or one a method."""
    given = answers if isinstance(answers, dict) else {"rallygap": answers} if answers else {}
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
    return ExamRecord(
        group=group, cell=cell, hidden=truth, gap_before_mm=gap, answers=given, **details
    )


def example_exam(seed=0, every=5):
    """Records of every n-th question: the first method mostly right, the second mostly not."""
    random = np.random.default_rng(seed)
    return [_example(question, random) for question in exam(NOMINAL, seed)[::every]]


def _example(question, random):
    trial = question.trial
    identities = tuple(one.identity for one in question.hidden)
    details = {"group": question.group, "cell": question.cell, "name": trial.name}
    details |= {"multiple": question.multiple, "shots": trial.shots, "withheld": trial.withheld}
    details |= {"noise": trial.cameras.position_noise, "dynamics": trial.dynamics}
    if random.random() < 0.05:
        return record(**details, parameters=identities, not_posed="not shown", answers={})
    truth = [hidden(one, indistinguishable=SIMILAR.get(one, ())) for one in identities]
    skills = dict(zip(METHODS, (0.9, 0.5), strict=True))
    answers = {name: _answer(question, random, skill) for name, skill in skills.items()}
    return record(*truth, **details, answers=answers)


def _answer(question, random, skill):
    if random.random() > skill:
        if question.hidden:
            return answer("no_gap", after=9.0)
        return answer("named", named(), after=9.0)
    if question.trial.withheld:
        return answer("unknown")
    estimates = [0.3 + 0.01 * random.standard_normal() for _ in question.hidden]
    pairs = zip(question.hidden, estimates, strict=True)
    causes = [named(one.identity, estimate=estimate) for one, estimate in pairs]
    return answer("named" if causes else "no_gap", *causes)
