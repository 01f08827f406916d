"""Results of the suite `faults`: reports/reliability, docs/reliability.md."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import write_csv

ROOT = Path(__file__).parents[1]
REPORT = ROOT / "reports" / "reliability"
NAMES = ("kills", "faults", "fuzz")  # of the tables


class Tables:
    """What a run of the suite has tried, a row each."""

    def __init__(self) -> None:
        self.rows: dict[str, list[Any]] = defaultdict(list)

    def add(self, name: str, rows: Iterable[Any]) -> None:
        """Add dataclasses to a table."""
        self.rows[name].extend(rows)

    def write(self, folder: Path) -> None:
        """Replace the tables of an earlier run."""
        if missing := [name for name in NAMES if name not in self.rows]:
            raise pytest.UsageError(f"--tables needs the whole suite; no row of {missing}")
        for name in NAMES:
            write_csv(folder / f"{name}.csv", pd.DataFrame(map(asdict, self.rows[name])))


COLLECTED = pytest.StashKey[Tables]()


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Write the tables of a run that has come to its end."""
    ended = exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    if ended and session.config.getoption("--tables"):
        session.config.stash.get(COLLECTED, Tables()).write(REPORT)


@pytest.fixture(scope="session")
def tables(request: pytest.FixtureRequest) -> Tables:
    """What the suite has tried; ``--tables`` writes it at the end."""
    return request.config.stash.setdefault(COLLECTED, Tables())
