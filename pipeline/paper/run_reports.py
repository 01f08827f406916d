"""The reports and parameters of a run, as the comparison with the paper reads them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.paper.assessments import Interval
from rallygap.pipeline.params import load_params, with_current_keys
from rallygap.pipeline.runtime.errors import InputError

PARAMS = "params.json"  # of the run of a profile


@dataclass(frozen=True)
class Reports:
    """The reports of a run.

    Attributes:
        folder: one folder per stage; it need not exist.
        params: of all stages; those of a kept run are what it had, and may lack some.
        written_in: the file that holds the parameters.
    """

    folder: Path
    params: Mapping[str, Any]
    written_in: Path = Path("params.yaml")

    def param(self, path: str) -> Any:
        """Return a parameter by its path, such as ``sim2sim.episodes``; ``None`` without it."""
        found: Any = self.params
        for key in path.split("."):
            found = found.get(key) if isinstance(found, Mapping) else None
        return found

    def table(self, file: str, keys: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
        """Return a table of the reports, empty if it or one of these columns does not exist.

        Args:
            file: of the table.
            keys: columns of names and whole numbers.
            numbers: columns of numbers.

        Raises:
            InputError: the file is no table, or has something else among its numbers.
        """
        path = self.folder / file
        try:
            table = pd.read_csv(path, keep_default_na=False, na_values=[""])
            there = {*keys, *numbers} <= set(table)
            return table.astype(dict.fromkeys(numbers, float)) if there else pd.DataFrame()
        except FileNotFoundError:
            return pd.DataFrame()
        except ValueError as error:
            raise InputError(path, f"is not a CSV table: {error}; run its stage again") from None

    def numbers(self, file: str, names: Sequence[str], **keys: str | int) -> list[float] | None:
        """Return numbers of the row with these values; ``None`` if one of them does not exist.

        Raises:
            ValueError: there are several such rows.
        """
        table = self.table(file, list(keys), names)
        for column, value in keys.items() if len(table) else ():
            table = table[table[column] == value]
        if len(table) > 1:
            raise ValueError(f"{file} has {len(table)} rows with {keys}")
        if table.empty or table.iloc[0][[*names]].isna().any():
            return None
        return [float(table.iloc[0][name]) for name in names]


class Reading(NamedTuple):
    """A number of ours.

    Attributes:
        value: the number; text where it is none.
        interval: of 95 %, where there is one.
        shown: how it is written, if not as value, interval and unit.
        assessment: where reading it decides the claim.
    """

    value: float | str
    interval: Interval | None = None
    shown: str = ""
    assessment: str = ""


def laptop_reports(root: Path) -> Reports:
    """Return the reports of the last run in a repository.

    Raises:
        InputError: its parameters are missing or broken.
    """
    return Reports(root / "reports", load_params(root / "params.yaml").model_dump(mode="json"))


def kept_reports(folder: Path) -> Reports:
    """Return the reports of a profile's run.

    Raises:
        InputError: its parameters are missing or broken.
    """
    path = folder / PARAMS
    params = read_json(path)
    if not isinstance(params, dict):
        raise InputError(path, "holds no parameters; run `python -m rallygap.stages.profile` again")
    return Reports(folder, dict(with_current_keys(params)), path)
