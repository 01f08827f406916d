"""Sheets of made-up trials, with any answers."""

import numpy as np

from models.exam.design.questions import exam
from models.exam.record import Answered, Hidden, Named, Sheet
from tests.models.exam.halls import NOMINAL

METHODS = ("rallygap", "sindy")
ALIKE = {"gravity": ("buoyancy",), "buoyancy": ("gravity",)}


def hidden(effect="wind", parameter="x", value=0.3, alike=(), name=None):
    return Hidden(
        name=name or effect,
        effect=effect,
        parameter=parameter,
        kind="missing_effect",
        nominal=0.0,
        value=value,
        alike=alike,
    )


def named(effect="wind", parameter="x", estimate=0.3, spread=0.02, possible=None, name=None):
    name = name or effect
    return Named(
        name=name,
        effect=effect,
        parameter=parameter,
        estimate=estimate,
        interval=None if spread is None else (estimate - spread, estimate + spread),
        possible=possible or (name,),
    )


def answered(answer, *causes, after=0.5):
    return Answered(answer=answer, causes=causes, after_mm=after)


def sheet(*truth, group="sweep", cell="base", answers=None, before=10.0, **settings):
    """A sheet on which ``truth`` is hidden; ``answers`` is one for rallygap, or one a method."""
    given = answers if isinstance(answers, dict) else {"rallygap": answers} if answers else {}
    details = {
        "name": f"{group}/made up",
        "world": "catalogue",
        "multiple": 3.0,
        "shots": 100,
        "noise": 0.003,
        "spin_labels": "per_row",
        "directions": 2,
        "withheld": (),
        "asked": tuple(f"{one.effect}.{one.parameter}" for one in truth),
        **settings,
    }
    gap = before if truth else None
    return Sheet(group=group, cell=cell, hidden=truth, before_mm=gap, answers=given, **details)


def whole_exam(seed=0, every=5):
    """Sheets of every so many-th question: the first method mostly right, the second mostly not."""
    random = np.random.default_rng(seed)
    return [_filled(question, random) for question in exam(NOMINAL, seed)[::every]]


def _filled(question, random):
    trial = question.trial
    truth = tuple(hidden(*name, value=0.3, alike=ALIKE.get(name[0], ())) for name in question.asked)
    details = {"group": question.group, "cell": question.cell, "name": trial.name}
    details |= {"multiple": question.multiple, "shots": trial.shots, "withheld": trial.withheld}
    details |= {"noise": trial.cameras.position_noise, "world": trial.world}
    if random.random() < 0.05:
        asked = tuple(f"{effect}.{parameter}" for effect, parameter in question.asked)
        return sheet(**details, asked=asked, not_posed="not shown", answers={})
    skills = dict(zip(METHODS, (0.9, 0.5), strict=True))
    return sheet(
        *truth,
        **details,
        answers={name: _answer(question, random, skill) for name, skill in skills.items()},
    )


def _answer(question, random, skill):
    if random.random() > skill:
        wrong = "no_gap" if question.asked else "named"
        return answered(wrong, *([] if question.asked else [named()]), after=9.0)
    if question.trial.withheld:
        return answered("unknown")
    estimates = [0.3 + 0.01 * random.standard_normal() for _ in question.asked]
    pairs = zip(question.asked, estimates, strict=True)
    causes = [named(*name, estimate=estimate) for name, estimate in pairs]
    return answered("named" if causes else "no_gap", *causes)
