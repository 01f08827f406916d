"""The reports of a run, as the comparison with the paper reads them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.artifacts import read_json
from pipeline.beside_paper.verdicts import Interval
from pipeline.errors import InputError
from pipeline.params import read_yaml
from pipeline.profiles import merged

ENDS = ("ci_low", "ci_high")


@dataclass(frozen=True)
class Reports:
    """What a run reports.

    Attributes:
        folder: with a folder a stage; it need not be there.
        params: of all stages.
    """

    folder: Path
    params: Mapping[str, Any]

    def param(self, path: str) -> Any:
        """Return a parameter by its path, such as ``sim2sim.episodes``; ``None`` without it."""
        found: Any = self.params
        for key in path.split("."):
            found = found.get(key) if isinstance(found, Mapping) else None
        return found

    def table(self, file: str) -> pd.DataFrame:
        """Return a table of the reports, without rows and columns where it is not there.

        Raises:
            InputError: the file is no table.
        """
        path = self.folder / file
        try:
            return pd.read_csv(path, keep_default_na=False, na_values=[""])
        except FileNotFoundError:
            return pd.DataFrame()
        except ValueError as error:
            raise InputError(path, f"is not a CSV table: {error}; run its stage again") from None

    def row(self, file: str, **keys: str | int) -> pd.Series | None:
        """Return the row of a table with these values; ``None`` where there is none."""
        table = self.table(file)
        for column, value in keys.items():
            if column not in table:
                return None
            table = table[table[column] == value]
        return table.iloc[0] if len(table) else None

    def interval(
        self, file: str, value: str, ends: tuple[str, str] = ENDS, **keys: str | int
    ) -> Interval | None:
        """Return a number of a table with its interval; ``None`` where it is not there."""
        row = self.row(file, **keys)
        if row is None or not {value, *ends} <= set(row.index) or row[[value, *ends]].isna().any():
            return None
        return Interval(*(float(row[name]) for name in (value, *ends)))


def laptop_reports(root: Path) -> Reports:
    """Return the reports of the last run in a repository.

    Raises:
        InputError: its parameters are missing or are not YAML.
    """
    return Reports(root / "reports", read_yaml(root / "params.yaml"))


def paper_reports(root: Path) -> Reports:
    """Return the reports of the run in the paper's size, if it was kept; else its parameters.

    Raises:
        InputError: parameters are missing or broken.
    """
    folder = root / "reports" / "paper"
    if (folder / "run.json").is_file():
        return Reports(folder, _kept_params(folder / "run.json"))
    params = read_yaml(root / "params.yaml")
    return Reports(folder, merged(params, read_yaml(root / "profiles" / "paper.yaml")))


def _kept_params(path: Path) -> dict[str, Any]:
    """Return the parameters in the record of a kept run."""
    record = read_json(path)
    params = record.get("params") if isinstance(record, dict) else None
    if not isinstance(params, dict):
        problem = "is missing or holds no parameters; `rallygap keep` writes it anew"
        raise InputError(path, problem, field="params")
    return params
