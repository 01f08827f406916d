"""The page on reliability has the numbers of the committed run."""

import pandas as pd

from tests.faults.kills import A_STAGE, IN_ALL, kills_a_stage
from tests.faults.page import REPORT, faults_table, kills_table, tables
from tests.faults.repository import ROOT, stages

PAGE = ROOT / "docs" / "reliability.md"


def test_the_page_has_the_committed_tables_or_says_how_to_make_them():
    page = PAGE.read_text(encoding="utf-8")
    assert "`make faults`" in page
    if (REPORT / "kills.csv").exists():
        assert [table for table in tables() if table not in page] == []


def test_there_are_enough_kills():
    assert kills_a_stage() >= A_STAGE
    assert kills_a_stage() * len(stages()) >= IN_ALL


def test_kills_that_came_too_late_do_not_count():
    rows = [("a", 0.25, True, 0, True), ("a", 0.9, False, 0, True), ("a", 0.7, True, 1, False)]
    columns = ["stage", "share", "hit", "half_written", "same_hashes"]
    *_, own, whole = kills_table(pd.DataFrame(rows, columns=columns)).splitlines()
    assert own == "| a | 2 | 25, 70 | 1 | 1 | 1 of 2 |"
    assert whole == "| all | 2 | | 1 | 1 | 1 of 2 |"


def test_a_fault_is_shown_with_what_the_run_said():
    row = {"fault": "disk full", "stage": "a", "happened": "stopped", "message": "x | y"}
    table = faults_table(pd.DataFrame([{**row, "same_hashes": True}]))
    assert table.splitlines()[-1] == "| disk full | a | stopped | `x \\| y` | yes |"
