"""Amended simulators beside the ones that they were, and beside the truth where it is known."""

from collections.abc import Sequence

import pandas as pd
from pydantic import BaseModel

from models.ball.simulator import Simulator

COLUMNS = ["effect", "parameter", "original", "amended", "low", "high", "truth"]


class NamedCause(BaseModel):
    """What is told here of a cause in a verdict's file.

    Attributes:
        name: of the effect, or of the number where an effect has several.
        parameter: the number.
        interval: 95 % of it.
    """

    name: str
    parameter: str
    interval: tuple[float, float]


class NamedCauses(BaseModel):
    """A verdict's file, as far as this table goes.

    The stage that makes the table trains policies for minutes. It reads no more than this, so that
    it does not depend on the code that finds causes, and a change there trains nothing anew.
    """

    effects: list[NamedCause]


def number_table(
    original: Simulator,
    amended: Simulator,
    causes: Sequence[NamedCause],
    truth: Simulator | None,
) -> pd.DataFrame:
    """Return one row a number in which the simulators differ; empty where one lacks the effect.

    Args:
        original: before.
        amended: after.
        causes: by which it was amended, for the 95 % intervals (``low``, ``high``).
        truth: the physics that flew the balls, where it is known.
    """
    simulators = {"original": original, "amended": amended, "truth": truth}
    known = {name: _numbers(one) for name, one in simulators.items() if one is not None}
    rows = []
    for effect, parameter in dict.fromkeys(key for numbers in known.values() for key in numbers):
        values = {name: numbers.get((effect, parameter)) for name, numbers in known.items()}
        if len(set(values.values())) > 1:
            found = values["amended"] != values["original"]
            low, high = _interval(causes, effect, parameter) if found else (None, None)
            ends = {"low": low, "high": high}
            rows.append({"effect": effect, "parameter": parameter, **values, **ends})
    return pd.DataFrame(rows, columns=COLUMNS)


def _numbers(simulator: Simulator) -> dict[tuple[str, str], float]:
    return {
        (effect, parameter): value
        for effect, values in simulator.effects.items()
        for parameter, value in values.items()
    }


def _interval(
    causes: Sequence[NamedCause], effect: str, parameter: str
) -> tuple[float | None, float | None]:
    """Return the interval of a number that was named; causes are called by either."""
    for cause in causes:
        if cause.parameter == parameter and cause.name in (effect, parameter):
            return cause.interval
    return None, None
