"""Tables of what the suite `faults` has tried: reports/reliability, docs/reliability.md."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.io.artifacts import write_csv

ROOT = Path(__file__).parents[1]
REPORT = ROOT / "reports" / "reliability"


class Tables:
    """Tables that grow row by row; each stands whole after every row.

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


@pytest.fixture(scope="session")
def tables(request: pytest.FixtureRequest) -> Tables:
    """What the suite has tried; written with ``--tables``."""
    return Tables(REPORT if request.config.getoption("--tables") else None)
