"""The page on reliability has the numbers of the committed run."""

import pandas as pd

from tests.faults.breakages import FAULTS
from tests.faults.kills import A_STAGE, IN_ALL
from tests.faults.page import faults_table, kills_table, tables
from tests.faults.repository import stages
from tests.reliability import REPORT, ROOT

PAGE = ROOT / "docs" / "reliability.md"


def test_the_page_has_the_committed_tables():
    page = PAGE.read_text(encoding="utf-8")
    assert "`make faults`" in page
    assert all(table in page for table in tables())


def test_enough_kills_hit_every_stage_and_left_nothing():
    kills = pd.read_csv(REPORT / "kills.csv")
    hits = kills[kills["hit"]].groupby("stage").size()
    assert set(hits.index) == set(stages())
    assert hits.min() >= A_STAGE and hits.sum() >= IN_ALL
    assert kills["same_hashes"].all()
    assert (kills["half_written"] == 0).all()


def test_every_fault_was_tried_and_ended_as_it_should():
    faults = pd.read_csv(REPORT / "faults.csv")
    tried = list(zip(faults["fault"], faults["stage"], strict=True))
    assert tried == [(fault.name, fault.stage) for fault in FAULTS]
    assert faults[["as_expected", "same_hashes"]].all(axis=None)


def test_kills_that_came_too_late_do_not_count():
    rows = [
        ("a", 0.25, True, 0, True, None),
        ("a", 0.9, False, 0, True, "rwlock"),
        ("a", 0.7, True, 1, False, None),
    ]
    columns = ["stage", "share", "hit", "half_written", "same_hashes", "repaired"]
    *_, own, whole = kills_table(pd.DataFrame(rows, columns=columns)).splitlines()
    assert own == "| a | 2 | 25, 70 | 1 | 1 | 1 of 2 | 1 |"
    assert whole == "| all | 2 | | 1 | 1 | 1 of 2 | 1 |"


def test_a_fault_is_shown_with_the_message_of_the_run():
    row = {"fault": "disk full", "stage": "a", "happened": "stopped", "message": "x | y"}
    table = faults_table(pd.DataFrame([{**row, "same_hashes": True}]))
    assert table.splitlines()[-1] == "| disk full | a | stopped | `x \\| y` | yes |"
