"""Competitive robot table tennis: ball states just after strokes of people and a robot."""

import json
from pathlib import Path
from typing import Any

import pandas as pd

from rallygap.pipeline.io.source_manifest import Description
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.files import read_text, source_file
from rallygap.pipeline.sources.source import (
    LAUNCH_COLUMNS,
    RawTable,
    Refusal,
    SourceContext,
    SourceData,
)

FILES = ("rallies.json", "serves.json")
KEYS = [
    "id",
    *("pos_x", "pos_y", "pos_z"),
    *("vel_x", "vel_y", "vel_z"),
    *("w_vel_x", "w_vel_y", "w_vel_z"),
]
LARGEST = 1e300  # JSON has integers that no float can hold

DESCRIPTION = Description(
    name="competitive_robot_table_tennis",
    kind="launches",
    spin="per_recording",
    licence="CC-BY 4.0",
    citation="D'Ambrosio et al.: Achieving Human Level Competitive Robot Table Tennis, ICRA 2025, "
    "arXiv 2408.03906",
    note="The set's axes are those of the table frame. States only, no paths; strokes of both "
    "sides of the table, so balls fly towards +y too.",
)


class CompetitiveRobotTableTennis:
    """The initial ball states that the paper's policies were trained on."""

    name = DESCRIPTION.name

    def read(self, context: SourceContext) -> SourceData:
        """Read the states of rallies and of serves."""
        folder = context.folder(self.name)
        return SourceData(DESCRIPTION, [_table(source_file(folder, name)) for name in FILES])


def _table(file: Path) -> RawTable:
    try:
        entries = json.loads(read_text(file))
    except (ValueError, RecursionError) as error:
        raise InputError(file, f"is not JSON: {error}") from None
    if not isinstance(entries, list):
        raise InputError(file, "must be a JSON list of ball states")
    states, refusals = [], []
    for row, entry in enumerate(entries, start=1):
        if (state := _state(entry)) is None:
            refusals.append(Refusal(file.name, row, "not a ball state"))
        else:
            states.append((row, *state))
    rows = pd.DataFrame(states, columns=["row", *LAUNCH_COLUMNS])
    return RawTable(file.stem, rows, file, refusals=refusals)


def _state(entry: Any) -> list[float] | None:
    """Return the numbers of one ball state, or ``None`` if it is not one."""
    values: list[Any] = [entry.get(key) for key in KEYS] if isinstance(entry, dict) else []
    numbers = [value for value in values if type(value) in (int, float)]
    if len(numbers) < len(KEYS) or type(numbers[0]) is not int:
        return None
    if any(abs(number) > LARGEST for number in numbers):
        return None
    return [numbers[0], *map(float, numbers[1:])]


source = CompetitiveRobotTableTennis()
