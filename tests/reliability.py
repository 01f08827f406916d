"""Results of the suite `faults`: reports/reliability, docs/reliability.md."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.io.artifacts import write_csv, write_json
from pipeline.runtime.git import git_commit

ROOT = Path(__file__).parents[1]
REPORT = ROOT / "reports" / "reliability"


class Tables:
    """Tables that grow row by row, each written whole after every row.

    Args:
        folder: where they are written; None leaves nothing.
    """

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.rows: dict[str, list[Any]] = defaultdict(list)

    def add(self, name: str, rows: Iterable[Any]) -> None:
        """Add dataclasses to a table, a row each."""
        self.rows[name].extend(rows)
        if self.folder is not None:
            table = pd.DataFrame([asdict(row) for row in self.rows[name]])
            write_csv(self.folder / f"{name}.csv", table)
            write_json(self.folder / "run.json", {"commit": git_commit(ROOT)})


@pytest.fixture(scope="session")
def tables(request: pytest.FixtureRequest) -> Tables:
    """What the suite has tried; written with ``--tables``."""
    return Tables(REPORT if request.config.getoption("--tables") else None)
