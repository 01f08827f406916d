"""Whatever kills or disturbs a stage, `dvc repro` then ends as if nothing had happened."""

import pytest

from tests.faults.breakages import FAULTS, suffer
from tests.faults.disks import may_mount
from tests.faults.kills import kill_stage, kills_a_stage
from tests.faults.repository import stages

pytestmark = pytest.mark.faults


@pytest.mark.parametrize("number", range(1, kills_a_stage() + 1))
@pytest.mark.parametrize("stage", stages())
def test_a_killed_stage_ends_as_an_undisturbed_one(repository, tables, stage, number):
    kills = list(kill_stage(repository, stage, number, kills_a_stage()))
    tables.add("kills", kills)
    assert kills[-1].hit
    for kill in kills:
        assert kill.same_hashes, kill.differences
        assert kill.half_written == 0


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault.name}, {fault.stage}")
def test_a_fault_is_borne_or_named_and_then_forgotten(repository, tables, fault):
    if fault.needs_root and not may_mount():
        pytest.skip("only root may mount a disk")
    suffered = suffer(repository, fault)
    tables.add("faults", [suffered])
    assert suffered.same_hashes, suffered.differences
    assert suffered.as_expected, suffered
    assert suffered.half_written == 0 or fault.damages == "rwlock"  # DVC was killed while it copied
