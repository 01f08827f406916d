"""The committed run of kills and faults is complete, and nothing failed in it."""

import pandas as pd

from experiments.clone import ROOT
from experiments.reliability.breakages import FAULTS
from experiments.reliability.kills import A_STAGE, IN_ALL
from experiments.reliability.repository import stages

REPORT = ROOT / "reports" / "reliability"


def test_enough_kills_hit_every_stage_and_left_nothing():
    kills = pd.read_csv(REPORT / "kills.csv")
    hits = kills[kills["hit"]].groupby("stage").size()
    assert set(hits.index) >= set(stages())
    assert hits.min() >= A_STAGE and hits.sum() >= IN_ALL
    assert kills["same_hashes"].all()
    assert (kills["half_written"] == 0).all()


def test_every_fault_was_tried_and_ended_as_it_should():
    faults = pd.read_csv(REPORT / "faults.csv")
    tried = list(zip(faults["fault"], faults["stage"], strict=True))
    assert tried == [(fault.name, fault.stage) for fault in FAULTS]
    assert faults[["as_expected", "same_hashes"]].all(axis=None)
