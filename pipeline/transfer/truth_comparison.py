"""Parameters of a simulator before and after it was amended, and their true values."""

from collections.abc import Sequence

import pandas as pd
from pydantic import BaseModel

from rallygap.models.ball.simulator import NODES, Simulator

COLUMNS = ["effect", "parameter", "original", "amended", "low", "high", "truth"]


class NamedCause(BaseModel):
    """The fields of a cause in a verdict file that the table needs.

    Attributes:
        identity: ``effect.parameter``.
        interval: 95 % confidence interval of the estimate.
    """

    identity: str
    interval: tuple[float, float]


class NamedCauses(BaseModel):
    """The causes of a verdict file.

    The stage that makes the table trains policies for minutes. It does not read the file by
    ``rallygap.models.gap.verdict``, so that it does not depend on the gap workflow and is not run
    again whenever that changes.
    """

    causes: list[NamedCause]


def number_table(
    original: Simulator, amended: Simulator, causes: Sequence[NamedCause], truth: Simulator | None
) -> pd.DataFrame:
    """Return one row a parameter in which the simulators differ; empty where one lacks the effect.

    Args:
        original: before.
        amended: after.
        causes: by which it was amended, for the 95 % intervals (``low``, ``high``).
        truth: the physics of the balls, where it is known.
    """
    simulators = {"original": original, "amended": amended, "truth": truth}
    known = {
        name: _parameters(simulator)
        for name, simulator in simulators.items()
        if simulator is not None
    }
    intervals = {cause.identity: cause.interval for cause in causes}
    rows = []
    for effect, parameter in dict.fromkeys(key for values in known.values() for key in values):
        values = {name: numbers.get((effect, parameter)) for name, numbers in known.items()}
        if len(set(values.values())) > 1:
            changed = values["amended"] != values["original"]
            interval = intervals.get(f"{effect}.{parameter}") if changed else None
            ends = dict(zip(("low", "high"), interval or (None, None), strict=True))
            rows.append({"effect": effect, "parameter": parameter, **values, **ends})
    return pd.DataFrame(rows, columns=COLUMNS)


def _parameters(simulator: Simulator) -> dict[tuple[str, str], float]:
    return {
        (effect, parameter): value
        for effect, values in simulator.effects.items()
        for parameter, value in values.items()
        if parameter != NODES  # a table, such as that of the cameras' error, is no number
    }
