"""The reports and parameters of a run, as the comparison with the paper reads them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from rallygap.pipeline.io.artifacts import read_json
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
    _tables: dict[str, pd.DataFrame] = field(default_factory=dict, compare=False)  # by file

    def param(self, path: str) -> Any:
        """Return a parameter by its path, such as ``sim2sim.episodes``; ``None`` without it."""
        value: Any = self.params
        for key in path.split("."):
            value = value.get(key) if isinstance(value, Mapping) else None
        return value

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
            if file not in self._tables:
                self._tables[file] = pd.read_csv(path, keep_default_na=False, na_values=[""])
            table = self._tables[file]
            if not {*keys, *numbers} <= set(table):
                return pd.DataFrame()
            texts = [name for name in numbers if not pd.api.types.is_numeric_dtype(table[name])]
            return table.astype(dict.fromkeys(texts, float)) if texts else table
        except FileNotFoundError:
            return pd.DataFrame()
        except ValueError as error:
            raise InputError(path, f"is not a CSV table: {error}; run its stage again") from None

    def numbers(self, file: str, names: Sequence[str], **keys: str | int) -> list[float] | None:
        """Return numbers of the row with these values; ``None`` if one of them does not exist.

        Raises:
            ValueError: there are several such rows.
        """
        table = rows_with(self.table(file, list(keys), names), keys)
        if len(table) > 1:
            raise ValueError(f"{file} has {len(table)} rows with {keys}")
        if table.empty or table[[*names]].isna().any(axis=None):
            return None
        return [float(table[name].iloc[0]) for name in names]


def rows_with(table: pd.DataFrame, keys: Mapping[str, str | int]) -> pd.DataFrame:
    """Return the rows with these values; an empty table may lack the columns."""
    if table.empty:
        return table
    return table[np.all([table[column] == value for column, value in keys.items()], axis=0)]


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
        problem = f"holds no parameters; run `python -m experiments.stages.profile {folder.name}`"
        raise InputError(path, problem)
    return Reports(folder, dict(with_current_keys(params)), path)
